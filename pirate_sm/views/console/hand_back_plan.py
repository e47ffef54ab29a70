"""Commands that restore what a phase needs, found in the background, and the waits it skips."""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import NamedTuple

from rich.text import Text

from pirate_sm.checking.plans import Beginnings, beginnings, restoring
from pirate_sm.core.events import GoTo
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Program, Wait, reached
from pirate_sm.core.robot import Plan, RobotSpec, RobotState, RulePlaces, state_change
from pirate_sm.views.console.availability import HandBackSituation
from pirate_sm.views.console.command_series import CommandSeries
from pirate_sm.views.console.dialogs import PickLine
from pirate_sm.views.showing.text_styles import STRONG, Part, line

SEEKING = "looking for commands that lead there …"
"""Shown in the list for a blocked phase until its restoring commands are known."""


class Ways(NamedTuple):
    """The plans for the phases at which the mission cannot be handed back now.

    Attributes:
        situation: The mission and the robot's situation in it.
        begun_in: States in which the phases of the mission begin.
        plans: Plans by phase.
    """

    situation: HandBackSituation
    begun_in: Beginnings
    plans: Mapping[str, Plan]


def look_for_ways(
    loaded: LoadedMission,
    situation: HandBackSituation,
    body: RobotState,
    places: RulePlaces | None,
    blocked: tuple[str, ...],
    known: Ways | None,
) -> Ways:
    """Return the plan for each blocked phase; takes some tenths of a second.

    Args:
        loaded: The mission.
        situation: The robot's situation.
        body: The commanded state of the robot.
        places: Progress of the mission's safety rules; None if they are not evaluated yet.
        blocked: Phases that cannot run now.
        known: Earlier results, perhaps for another situation or mission.
    """
    same = known is not None and known.situation.mission == situation.mission
    begun_in = known.begun_in if known is not None and same else beginnings(loaded)
    found = restoring(loaded, blocked, body, begun_in, places)
    return Ways(situation, begun_in, found)


def names(robot: RobotSpec, plan: Plan) -> tuple[str, ...]:
    """Return the names of the plan's commands."""
    return tuple(robot.commands[step.command].name for step in plan.steps)


def with_way(robot: RobotSpec, choice: PickLine, plan: Plan | None) -> PickLine:
    """Return the list's line of a blocked phase, with the commands that would restore it."""
    if plan is None:
        return choice
    step = plan.hindered
    if step is None:
        return choice._replace(detail=f"first {', '.join(names(robot, plan))}", reason="")
    name = robot.commands[step.command].name
    return choice._replace(reason=f"only {name} leads there: {step.hindrance}; {choice.reason}")


def leap(phase: str, waits: str) -> str:
    """Return the question before a hand-back without commands that skips waits."""
    return f"Nothing checks where the robot is{_unseen(waits)}. Hand back at {phase}?"


def _unseen(waits: str) -> str:
    """Return which waits were not passed, as far as the console can know; empty if all were.

    Stopped runs of the same mission count; runs before the console was opened are not known.
    """
    seen = "this console has not seen the mission pass"
    return f", and since its last start {seen} {waits}" if waits else ""


def question(robot: RobotSpec, phase: str, plan: Plan, body: RobotState, waits: str) -> str:
    """Return the question before the commands are given.

    Args:
        robot: The robot.
        phase: The phase of the hand-back.
        plan: The plan for it.
        body: The robot's commanded state.
        waits: The result of :func:`~pirate_sm.views.console.hand_back_plan.not_passed`.
    """
    given = names(robot, plan)
    each = "It is awaited" if len(given) == 1 else "Each is awaited"
    return (
        f"Only states are restored. Nothing checks where the robot is{_unseen(waits)}. "
        f"{phase} needs {_needed(robot, plan, body)}. Give {', '.join(given)}, then hand back "
        f"there? {each}. A failure ends the series, and so do Esc and whatever else you ask for; "
        "Space stops the robot."
    )


def hand_back(robot: RobotSpec, phase: str, plan: Plan) -> GoTo:
    """Return the event that hands the mission back, valid after the plan."""
    change = state_change(robot, plan.body)
    return GoTo(phase, change.states, change.unconfirmed)


def _needed(robot: RobotSpec, plan: Plan, body: RobotState) -> str:
    """Return the states that are not reached or not confirmed yet."""
    now, then = state_change(robot, body), state_change(robot, plan.body)
    doubted = set(now.unconfirmed) - set(then.unconfirmed)
    each = zip(robot.regions, now.states, then.states, strict=True)
    return ", ".join(
        f"{region} {after}" + (" confirmed" if before == after else "")
        for region, before, after in each
        if before != after or region in doubted
    )


def bar(series: CommandSeries | None) -> list[Text]:
    """Return the progress of a series of commands; nothing without one."""
    if series is None or not series.active:
        return []
    parts: list[Part] = [(f" ▶ for {series.then.phase}:  ", STRONG)]
    for number, name in enumerate(series.commands):
        sign = "✓" if number < series.done else "…" if number == series.done else " "
        parts.append((f"{name} {sign}  ", STRONG if sign == "…" else ""))
    return [line(*parts, "  (Esc: no more)")]


def not_passed(program: Program, phase: str, passed: Container[str]) -> str:
    """Return the waits before the phase that have not been passed, in words; empty if none.

    Args:
        program: The mission.
        phase: One of its phases.
        passed: Places of the passed waits.
    """
    left = [each.phase for each in waits_before(program, phase) if each.place not in passed]
    phases = list(dict.fromkeys(left))
    return f"its wait{'s' if len(left) > 1 else ''} of {', '.join(phases)}" if phases else ""


def waits_before(program: Program, phase: str) -> tuple[Wait, ...]:
    """Return the waits of which a trigger must fire on every way from the start to the phase.

    Failures, faults and time limits are ways too: a phase that they can reach from anywhere has
    no waits before it.
    """
    goal = program.enter(phase)
    if goal is None or goal not in reached(program):
        return ()
    return tuple(
        each
        for at, each in enumerate(program.instructions)
        if isinstance(each, Wait) and goal not in reached(program, without=at)
    )
