"""Find what a mission that goes on still depends on and nobody knows."""

from __future__ import annotations

from collections.abc import Iterator
from math import isnan

from pirate_sm.core._engine.mission.program import Branch, Do, Program, Wait
from pirate_sm.core._engine.mission.successors import reached
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.resuming.reconciling import VerdictTable
from pirate_sm.core._engine.resuming.resumption import Resumption
from pirate_sm.core._engine.robot.confirmation_spec import AnglesSpec
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import states_of
from pirate_sm.core._engine.robot.sensor_verdict import spec_of


def unknowns(robot: RobotSpec, program: Program, table: VerdictTable) -> tuple[str, ...]:
    """Return the clamps and angles that the sensors do not show.

    A state that the command under way was to bring about is left out: it is given again at once.

    Args:
        robot: The robot.
        program: The program of the resumption.
        table: What the sensors have shown.
    """
    names = states_of(robot, table.hypothesis.body)
    goal = program.instructions[-1]
    under_way = goal.command if isinstance(goal, Do) else None
    return tuple(
        f"{each.about} {each.state}: {each.why}"
        for each in table.verdicts
        if each.word != "confirmed"
        and each.mark.command != under_way
        and (each.mark.kind == "part" or isinstance(spec_of(robot, names, each.mark), AnglesSpec))
    )


def unknown_position(robot: RobotSpec, program: Program, it: Resumption) -> str:
    """Return where the mission still reads a position that nobody knows; empty if nowhere."""
    read = position_read(robot, program, it.entry.origin) if it.adrift else iter(())
    place = next((place for _, place in read), "")
    return f"the position: the mission reads it ({place})" if place else ""


def position_read(robot: RobotSpec, program: Program, origin: Numbers) -> Iterator[tuple[int, str]]:
    """Yield the instructions from which the odometry is read, with the places of their conditions.

    A change of the odometry is read too if the value from which it counts is unknown.

    Args:
        robot: The robot.
        program: The program of the resumption.
        origin: The signals from which a wait counts that counts on.
    """
    if robot.odometry < 0:
        return
    name = robot.vocabulary.numbers[robot.odometry]
    changes = robot.vocabulary.with_changes.numbers
    change = changes[len(robot.vocabulary.numbers) + robot.odometry]
    lost = bool(origin) and isnan(origin[robot.odometry])
    for index in sorted(reached(program)):
        match program.instructions[index]:
            case Branch(condition=condition, place=place):
                if name in condition.names:
                    yield index, place
            case Wait(triggers=triggers, counts_on=counts_on, place=place):
                for each in triggers:
                    read = each.condition.names if each.condition is not None else ()
                    if name in read or (lost and counts_on and change in read):
                        yield index, each.place or place
            case _:
                pass
