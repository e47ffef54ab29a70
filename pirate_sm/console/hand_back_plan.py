"""What restores the configuration that a phase needs: found beside everything else, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rich.text import Text

from pirate_sm.checking.plans.restoring_commands import Beginnings, beginnings, restoring
from pirate_sm.console.availability import Situation
from pirate_sm.console.command_series import Series
from pirate_sm.console.dialogs import Choice
from pirate_sm.engine.robot.planning import Plan
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import RobotState, state_change
from pirate_sm.engine.state import EngineState
from pirate_sm.model.events import GoTo
from pirate_sm.showing.snapshot import Scene
from pirate_sm.showing.text_styles import STRONG, Part, line

SEEKING = "looking for commands that lead there …"
"""What the list says of a phase that cannot run, until it is known what restores it."""


class Ways(NamedTuple):
    """The plans for the phases at which the mission cannot be handed back as the robot is.

    Attributes:
        scene: The mission that they are for.
        situation: That of the robot.
        begun_in: Where the phases of the mission begin.
        plans: By phase.
    """

    scene: Scene
    situation: Situation
    begun_in: Beginnings
    plans: Mapping[str, Plan]


def look_for_ways(
    scene: Scene,
    situation: Situation,
    state: EngineState,
    blocked: tuple[str, ...],
    known: Ways | None,
) -> Ways:
    """Return what restores each blocked phase; takes some tenths of a second.

    Args:
        scene: The mission.
        situation: That of the robot.
        state: The engine's.
        blocked: Phases that cannot run as the robot is.
        known: What was found before, perhaps for another situation.
    """
    same = known is not None and known.scene is scene
    begun_in = known.begun_in if known is not None and same else beginnings(scene.loaded)
    found = restoring(scene.loaded, blocked, state.robot, begun_in, state.rules)
    return Ways(scene, situation, begun_in, found)


def names(robot: RobotSpec, plan: Plan) -> tuple[str, ...]:
    """Return the names of the plan's commands."""
    return tuple(robot.commands[step.command].name for step in plan.steps)


def with_way(robot: RobotSpec, choice: Choice, plan: Plan | None) -> Choice:
    """Return the line of a phase that cannot run as the robot is, with what would restore it."""
    if plan is None:
        return choice
    step = plan.hindered
    if step is None:
        return choice._replace(detail=f"first {', '.join(names(robot, plan))}", reason="")
    name = robot.commands[step.command].name
    return choice._replace(reason=f"only {name} leads there: {step.hindrance}; {choice.reason}")


def leap(phase: str, waits: str) -> str:
    """Return what the operator is asked before a hand-back that needs no commands, over waits."""
    return (
        f"Nothing checks where the robot stands, and in this run the mission has not passed "
        f"{waits}. Hand back at {phase}?"
    )


def question(robot: RobotSpec, phase: str, plan: Plan, body: RobotState, waits: str) -> str:
    """Return what the operator is asked before the commands are given.

    Args:
        robot: The robot.
        phase: Where the mission is to be handed back.
        plan: What leads there.
        body: What the robot has been commanded to.
        waits: What :func:`~pirate_sm.console.waits_before.not_passed` says.
    """
    given = names(robot, plan)
    each = "It is awaited" if len(given) == 1 else "Each is awaited"
    leaps = f", and in this run the mission has not passed {waits}" if waits else ""
    return (
        f"Only states are restored. Nothing checks where the robot stands{leaps}. "
        f"{phase} needs {_needed(robot, plan, body)}. Give {', '.join(given)}, then hand back "
        f"there? {each}. A failure ends the series, and so do Esc and whatever else you ask for; "
        "Space stops the robot."
    )


def hand_back(robot: RobotSpec, phase: str, plan: Plan) -> GoTo:
    """Return the event that hands the mission back, if the robot has then come where it should."""
    change = state_change(robot, plan.body)
    return GoTo(phase, change.states, change.unconfirmed)


def _needed(robot: RobotSpec, plan: Plan, body: RobotState) -> str:
    """Return the states that are not so yet, or not confirmed."""
    now, then = state_change(robot, body), state_change(robot, plan.body)
    doubted = set(now.unconfirmed) - set(then.unconfirmed)
    each = zip(robot.regions, now.states, then.states, strict=True)
    return ", ".join(
        f"{region} {after}" + (" confirmed" if before == after else "")
        for region, before, after in each
        if before != after or region in doubted
    )


def bar(series: Series | None) -> list[Text]:
    """Return how far a series of commands has come; nothing while there is none."""
    if series is None or not series.active:
        return []
    parts: list[Part] = [(f" ▶ for {series.then.phase}:  ", STRONG)]
    for number, name in enumerate(series.commands):
        sign = "✓" if number < series.done else "…" if number == series.done else " "
        parts.append((f"{name} {sign}  ", STRONG if sign == "…" else ""))
    return [line(*parts, "  (Esc: no more)")]
