"""`pirate plan`: the fewest commands between two configurations of a robot.

The JSON is described by ``docs/schemas/plan.schema.json``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from shutil import get_terminal_size
from textwrap import wrap
from typing import Any

from pirate_sm.checking.plans import WayToStates, beginnings, hindered, restoring, way_to
from pirate_sm.cli.options.declaring import read_pairs
from pirate_sm.cli.options.files import PlanOptions
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.generated_missions import by_hand
from pirate_sm.core.loading import LoadedRobot, load_mission, load_robot, read_states
from pirate_sm.core.robot import Plan, RobotSpec, RobotState, at_rest_in, states_of
from pirate_sm.core.spelling import meant
from pirate_sm.core.visible import visible

FOUND, NONE = 0, 1


FORMAT = 1


_FORM = "REGION=STATE, more of them separated by commas"


_NARROWEST, _WIDEST = 60, 100


_TOGETHER = "\N{NO-BREAK SPACE}"


@dataclass(frozen=True)
class FoundPlan:
    """The result, with the request.

    Attributes:
        states: The requested states, by region.
        phase: The requested phase, ``MISSION:PHASE``.
    """

    robot: RobotSpec
    body: RobotState
    way: WayToStates
    states: dict[str, str] = field(default_factory=dict)
    phase: str | None = None


def print_plan(options: PlanOptions) -> int:
    """Print the commands, or why there are none; return the exit code.

    Raises:
        LoadError: The files have errors.
        UsageError: There is no such robot, mission, phase or state.
    """
    if bool(options.to) == (options.to_phase is not None):
        raise UsageError("say where to, with either --to or --to-phase")
    loaded = load_robot(library.find_robot(options.robot, Path.cwd()))
    body = _begin(loaded, _read("--from", options.begin or ()))
    if options.to_phase is not None:
        found = _to_phase(loaded, body, options.to_phase)
    else:
        found = _to_states(loaded, body, _read("--to", options.to or ()))
    if options.json:
        print(json.dumps(_data(found), indent=1))
    else:
        print("\n".join(map(visible, _lines(found))))
    return NONE if found.way.plan is None else FOUND


def _read(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Return the pairs in ``REGION=STATE, REGION=STATE``; a mission's ``==`` is accepted too."""
    parts = [part for text in texts for part in text.replace("==", "=").split(",") if part.strip()]
    if texts and not parts:
        raise UsageError(f"{option} names no state: expected {_FORM}")
    return read_pairs(option, parts, _FORM)


def _begin(loaded: LoadedRobot, states: dict[str, str]) -> RobotState:
    """Return the robot in these states, with the others as on the shortest way to them."""
    body = at_rest_in(loaded.normal, loaded.table.initial)
    way = _way(loaded, body, states)
    if way.plan is None:
        raise UsageError(f"--from: {way.reason}")
    return at_rest_in(loaded.normal, way.plan.body.configuration)


def _way(loaded: LoadedRobot, body: RobotState, states: dict[str, str]) -> WayToStates:
    program = replace(by_hand(loaded).program, rules=loaded.rules)
    return way_to(loaded.normal, program, body, read_states(loaded.table, states))


def _to_states(loaded: LoadedRobot, body: RobotState, states: dict[str, str]) -> FoundPlan:
    return FoundPlan(loaded.normal, body, _way(loaded, body, states), states=states)


def _to_phase(loaded: LoadedRobot, body: RobotState, text: str) -> FoundPlan:
    name, colon, phase = text.rpartition(":")
    if not colon or not name or not phase:
        raise UsageError(f"--to-phase '{text}': expected MISSION:PHASE")
    mission = load_mission(library.find_mission(name))
    if mission.loaded_robot.folder != loaded.folder:
        raise UsageError(f"{name} is a mission for {mission.robot.name}, not {loaded.normal.name}")
    phases = mission.program.phases
    if phase not in phases:
        raise UsageError(f"{name} has no phase '{phase}'; {meant(phase, phases)}")
    body = at_rest_in(mission.robot, body.configuration)
    plan = restoring(mission, [phase], body, beginnings(mission)).get(phase)
    if plan is None:
        way = WayToStates(
            None,
            f"no commands lead to states from which {name} can continue with {phase} and succeed",
        )
    else:
        way = (
            WayToStates(None, hindered(loaded.normal, plan)) if plan.hindered else WayToStates(plan)
        )
    return FoundPlan(mission.robot, body, way, phase=text)


def _lines(found: FoundPlan) -> Iterator[str]:
    robot, width = found.robot, min(max(get_terminal_size().columns, _NARROWEST), _WIDEST)
    target = f"where {found.phase} can begin" if found.phase else _pairs(found.states)
    yield from _wrapped(f"from  {_pairs(_states(robot, found.body))}", width, 6)
    yield from _wrapped(f"to    {target}", width, 6)
    yield ""
    plan = found.way.plan
    if plan is None:
        yield from _wrapped(f"None: {found.way.reason}.", width, 6)
    elif not plan.steps:
        yield "Nothing to do: the robot is in these states already."
    else:
        yield from _table(found, plan, width)


def _table(found: FoundPlan, plan: Plan, width: int) -> Iterator[str]:
    robot = found.robot
    rows = [("", "command", "held by", "what changes")]
    rows += [
        (
            str(number),
            each["command"],
            ", ".join(each["held_by"]) or "–",
            _pairs(each["changed"]) or "nothing: it is confirmed",
        )
        for number, each in enumerate(_steps(found, plan), 1)
    ]
    first, second, third = (max(len(row[column]) for row in rows) for column in range(3))
    for number, command, held, changed in rows:
        start = f"{number:>{first}}  {command:<{second}}  {held:<{third}}  "
        yield from _wrapped(start + changed, width, len(start))
    count = len(plan.steps)
    yield ""
    yield f"{count} command{'s' if count > 1 else ''}, nominally {plan.nominal_s(robot):g} s"


def _data(found: FoundPlan) -> dict[str, Any]:
    plan = found.way.plan
    return {
        "format": FORMAT,
        "robot": found.robot.name,
        "from": _states(found.robot, found.body),
        "to": found.states,
        "phase": found.phase,
        "found": plan is not None,
        "reason": found.way.reason,
        "commands": [] if plan is None else list(_steps(found, plan)),
        "nominal_s": None if plan is None else plan.nominal_s(found.robot),
    }


def _steps(found: FoundPlan, plan: Plan) -> Iterator[dict[str, Any]]:
    robot, before = found.robot, _states(found.robot, found.body)
    for step in plan.steps:
        spec, after = robot.commands[step.command], _states(robot, step.body)
        yield {
            "command": spec.name,
            "states": after,
            "changed": {
                region: state for region, state in after.items() if state != before[region]
            },
            "held_by": [robot.parts[part] for part in sorted(robot.held[step.body.configuration])],
            "nominal_s": spec.nominal_s,
        }
        before = after


def _pairs(states: Mapping[str, str]) -> str:
    return ", ".join(f"{region}{_TOGETHER}{state}" for region, state in states.items())


def _wrapped(text: str, width: int, indent: int) -> list[str]:
    """Return the wrapped lines of a text, with each region next to its state."""
    lines = wrap(text, width, subsequent_indent=" " * indent, break_on_hyphens=False)
    return [line.replace(_TOGETHER, " ") for line in lines]


def _states(robot: RobotSpec, body: RobotState) -> dict[str, str]:
    return dict(zip(robot.regions, states_of(robot, body), strict=True))
