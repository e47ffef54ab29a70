"""Find commands that lead a robot to given states, or back into a phase of a mission."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

from pirate_sm.checking.exploring.exploration import Explored, index_exploration
from pirate_sm.checking.exploring.explore import MOST_WORK, conditions_of, explore
from pirate_sm.core.effects import PhaseChange
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Do, Program, Require
from pirate_sm.core.robot import (
    ChartTable,
    Configuration,
    Plan,
    RobotSpec,
    RobotState,
    RulePlaces,
    at_rest_in,
    plans,
    refusal,
)

# --- phase entry ---------------------------------------------------------------------------------


def why_not_from(loaded: LoadedMission, phase: str, body: RobotState) -> str:
    """Return why the mission cannot resume at the phase; empty if it can.

    Args:
        loaded: The mission.
        phase: One of its phases.
        body: The commanded state of the robot, with no array in flight.
    """
    book = _from(loaded, phase, body)
    if book is None:
        return "the mission has no such phase"
    refused = _broken(book)
    if not refused and not any(outcome == "succeeded" for outcome, _ in book.ends):
        return "from there no path leads to an end that succeeds"
    return refused


def refused_from(
    loaded: LoadedMission, phase: str, body: RobotState, most_work: float
) -> tuple[str, float]:
    """Return which command is refused, or which rule broken, from a phase on; empty if none.

    Args:
        loaded: The mission.
        phase: One of its phases.
        body: As for :func:`why_not_from`.
        most_work: The limit of the exploration; without any left nothing is found.

    Returns:
        The refusal, and the work that it has taken.
    """
    book = _from(loaded, phase, body, most_work) if most_work > 0 else None
    return (_broken(book), book.found.work) if book is not None else ("", 0.0)


def _from(
    loaded: LoadedMission, phase: str, body: RobotState, most_work: float = MOST_WORK
) -> Explored | None:
    """Return what can happen from a phase on; None if the mission does not have it."""
    begin = loaded.program.beginning(phase, body.control)
    if begin is None:
        return None
    body = body.at_rest()._replace(control=body.control)
    program = replace(loaded.program, start=begin)
    conditions = conditions_of(loaded)
    found = explore(loaded.robot, program, conditions, body=body, most_work=most_work)
    return index_exploration(found)


def _broken(book: Explored) -> str:
    return next(iter(book.broken), "") or _refused(book, book.found.program.instructions)


def _refused(book: Explored, instructions: tuple[object, ...]) -> str:
    """Return the first refusal that its step does not handle; empty without one."""
    expected = {each.place for each in instructions if isinstance(each, Do) and each.expected}
    places = {each.place for each in instructions if isinstance(each, Do | Require)}
    found = [
        (min(visits.refused), visits.name, place, visits.reasons[min(visits.refused)])
        for place, visits in book.visits.items()
        if visits.refused and place in places - expected
    ]
    if not found:
        return ""
    _, name, place, reason = min(found)
    return f"{name} ({place}) would be refused as {reason}"


# --- restoring commands --------------------------------------------------------------------------


Beginnings = Mapping[str, frozenset[int]]
"""For each phase the configurations in which a mission run from its start enters it."""


def beginnings(loaded: LoadedMission) -> Beginnings:
    """Explore the mission and return the configurations in which each phase begins.

    It begins as its file says, also where the robot was adopted elsewhere.
    """
    found: dict[str, set[int]] = {}
    table, wanted = loaded.robot.table, loaded.mission.starts_in or {}
    initial = zip(table.regions, table.configurations[table.initial], strict=True)
    at_start = table.index_of(tuple(wanted.get(region, state) for region, state in initial))
    program = loaded.program
    if at_start is not None:
        program = replace(program, start_configuration=at_start)
    exploration = explore(loaded.robot, program, conditions_of(loaded))
    for step in exploration.steps:
        for effect in step.effects:
            if isinstance(effect, PhaseChange):
                body = exploration.nodes[step.target].state.robot
                found.setdefault(effect.phase, set()).add(body.configuration)
    return {phase: frozenset(configurations) for phase, configurations in found.items()}


def restoring(
    loaded: LoadedMission,
    phases: Collection[str],
    body: RobotState,
    begun_in: Beginnings,
    places: RulePlaces | None = None,
) -> dict[str, Plan]:
    """Return for each phase the best plan after which the mission can resume there.

    A plan ends in a configuration in which the mission enters the phase by itself, and from which
    :func:`why_not_from` finds no obstacle. Phases that no commands reach are left out. A plan with
    a hindrance explains the obstacle and must not be executed.

    Args:
        loaded: The mission.
        phases: The phases to examine.
        body: The commanded state of the robot, with no array in flight.
        begun_in: The result of :func:`beginnings`.
        places: Progress of the mission's safety rules; None if they are not evaluated yet.
    """
    body = body.at_rest()._replace(control=body.control)
    missing = {phase: begun_in[phase] for phase in phases if begun_in.get(phase)}
    hopeless = {phase for phase in missing if _never(loaded, phase, missing[phase])}
    found: dict[str, Plan] = {}
    for plan in plans(loaded.robot, loaded.program, body, places):
        for phase, configurations in missing.items():
            if phase in found or phase in hopeless or plan.body.configuration not in configurations:
                continue
            if not why_not_from(loaded, phase, plan.body):
                found[phase] = plan
        if len(found) + len(hopeless) == len(missing):
            break
    return found


def _never(loaded: LoadedMission, phase: str, configurations: Collection[int]) -> bool:
    """Return whether the phase cannot succeed even in the configurations in which it begins."""
    return all(
        why_not_from(loaded, phase, at_rest_in(loaded.robot, each)) for each in configurations
    )


# --- ways to states ------------------------------------------------------------------------------


Wanted = Mapping[int, str]
"""The target state by the index of its region; other regions may have any state."""


class WayToStates(NamedTuple):
    """The result of a search.

    Attributes:
        plan: The commands; None if there are none.
        reason: Why there are no commands.
    """

    plan: Plan | None
    reason: str = ""


def way_to(robot: RobotSpec, program: Program, body: RobotState, wanted: Wanted) -> WayToStates:
    """Return the fewest commands that lead to the states.

    Args:
        robot: The robot.
        program: The program whose safety rules are active.
        body: The present state of the robot, with no command under way.
        wanted: The target states.
    """
    conflict = _conflict(robot.table, wanted)
    if conflict:
        return WayToStates(None, conflict)
    seen: set[int] = set()
    for plan in plans(robot, program, body):
        seen.add(plan.body.configuration)
        if _has(robot.table.configurations[plan.body.configuration], wanted):
            return WayToStates(None, hindered(robot, plan)) if plan.hindered else WayToStates(plan)
    return WayToStates(None, _unreached(robot, body, wanted, seen))


def hindered(robot: RobotSpec, plan: Plan) -> str:
    """Return why a plan must not be executed; empty if it may be."""
    step = plan.hindered
    if step is None:
        return ""
    name = robot.commands[step.command].name
    return f"no safe way leads there; the shortest takes {name}: {step.hindrance}"


def _has(configuration: Configuration, wanted: Wanted) -> bool:
    return all(configuration[region] == state for region, state in wanted.items())


def _conflict(table: ChartTable, wanted: Wanted) -> str:
    """Return the smallest set of states that exclude each other, as text; empty if none do."""
    if any(_has(each, wanted) for each in table.configurations):
        return ""
    for size in range(1, len(wanted) + 1):
        for regions in combinations(wanted, size):
            some = {region: wanted[region] for region in regions}
            if not any(_has(each, some) for each in table.configurations):
                return _exclusion(table, some)
    raise AssertionError("all of them together are excluded")


def _exclusion(table: ChartTable, wanted: Wanted) -> str:
    *others, region = wanted
    rest = {other: wanted[other] for other in others}
    beside = {each[region] for each in table.configurations if _has(each, rest)}
    names = [name for name in table.states[region] if name in beside]
    beside_them = f"with {_said(table, rest)}, " if rest else ""
    return (
        f"no commands ever lead to {_said(table, wanted)}: {beside_them}{table.regions[region]} is "
        f"{_either(names)}"
    )


def _unreached(robot: RobotSpec, body: RobotState, wanted: Wanted, seen: Collection[int]) -> str:
    """Return which of the states cannot be reached from here, and why."""
    table = robot.table
    for region, state in wanted.items():
        if any(table.configurations[each][region] == state for each in seen):
            continue
        makers = _makers(table, region, state)
        why = "; ".join(
            f"{table.commands[command]}, now {reason}"
            for command in makers
            if (reason := refusal(robot, body, command))
        )
        told = f"; it is made by {why}" if why else ""
        return f"no commands lead from here to {_said(table, {region: state})}{told}"
    return f"no commands lead from here to all of {_said(table, wanted)} at once"


def _makers(table: ChartTable, region: int, state: str) -> list[int]:
    """Return the commands that lead the region to the state from some configuration."""
    return [
        command
        for command in range(len(table.commands))
        if any(
            states[region] != state
            and table.configurations[table.follow(index, command)][region] == state
            for index, states in enumerate(table.configurations)
        )
    ]


def _said(table: ChartTable, wanted: Wanted) -> str:
    return " and ".join(f"{table.regions[region]} {state}" for region, state in wanted.items())


def _either(names: Iterable[str]) -> str:
    *rest, last = names
    return f"{', '.join(rest)} or {last}" if rest else last
