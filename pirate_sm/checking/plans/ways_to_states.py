"""Find the commands that lead to given states, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from itertools import combinations
from typing import NamedTuple

from pirate_sm.core.program import Program
from pirate_sm.core.robot import (
    ChartTable,
    Configuration,
    Plan,
    RobotSpec,
    RobotState,
    plans,
    refusal,
)

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
        program: The program whose safety rules are in force.
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
