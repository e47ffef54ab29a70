"""Compute what a stage of a command's actuation writes, and whether it has been reached.

A command with a posture first brings the robot to the posture, in the stage ``POSTURE``. The
stages of the states that it leads to follow.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan

from pirate_sm.engine.control.loops import Loop, Loops, begun, ends_with_command, quantised
from pirate_sm.engine.control.torque_loop import TorqueLoop
from pirate_sm.engine.robot.command_spec import StageSpec
from pirate_sm.engine.robot.criteria import CriterionSpec
from pirate_sm.engine.robot.done import holds
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import (
    POSTURE,
    STOPPED,
    Mark,
    Motion,
    Numbers,
    RobotState,
    known_values,
    posture_of,
    states_of,
)
from pirate_sm.engine.robot.unmet_conditions import seekers_away
from pirate_sm.engine.sensing.known_signals import Sensing


def stage_array(
    robot: RobotSpec,
    state: RobotState,
    motion: Motion,
    sensing: Sensing,
    regions: tuple[int, ...],
    stage: int,
) -> tuple[Numbers, Loops]:
    """Return the array and the loops of one stage of the regions' states.

    A loop of a state continues where the stage does not write its slot. A posture that depends on
    an unknown angle changes nothing.
    """
    target = robot.table.configurations[motion.target]
    values = list(known_values(state.latest, sensing.numbers, robot))
    loops = {each.slot: each for each in state.loops if not ends_with_command(each)}
    posture = posture_of(robot, motion) if stage == POSTURE else None
    if posture is not None:
        if not motion.blind:
            _write(robot, sensing, posture.writes, values, loops)
        return tuple(values), tuple(loops.values())
    for region in regions:
        stages = state.stages(robot, region, target[region])
        _write(robot, sensing, stages[min(stage, len(stages) - 1)], values, loops)
    return tuple(values), tuple(loops.values())


def followed(robot: RobotSpec, state: RobotState, motion: Motion, sensing: Sensing) -> RobotState:
    """Return the state; in a posture, with each share of a joint's angle taken anew.

    A joint that the posture moves may open the apex whose angle the posture names.
    """
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    if posture is None:
        return state
    shares = {write.slot: write for write in posture.writes if write.share_of >= 0}
    loops = list(state.loops)
    for at, loop in enumerate(loops):
        if write := shares.get(loop.slot):
            loops[at] = begun(write, robot.slots[loop.slot], sensing.numbers, loop) or loop
    return state if tuple(loops) == state.loops else state._replace(loops=tuple(loops))


def switched_array(
    robot: RobotSpec, state: RobotState, sensing: Sensing, control: int
) -> tuple[Numbers, Loops]:
    """Return the array and the loops that actuate the present states by another control.

    Only slots are written to which the two controls write something else. Wheels that were stopped
    from outside their state stay stopped, and a joint that a command has brought to an angle stays
    there: commands alone drive and seek. A joint is kept at its torque again if a pause or a fault
    has stopped its loop.
    """
    values = list(known_values(state.latest, sensing.numbers, robot))
    loops = {each.slot: each for each in state.loops}
    after = state._replace(control=control)
    for region, name in enumerate(states_of(robot, state)):
        if Mark("region", region, STOPPED) in state.marks:
            continue
        before = state.stages(robot, region, name)[-1]
        stage = after.stages(robot, region, name)[-1]
        changed = tuple(
            write._replace(how="set", value=0.0) if write.how == "seek" else write
            for write in stage
            if write not in before or (write.how == "bear" and _let_go(robot, write.slot, loops))
        )
        _write(robot, sensing, changed, values, loops)
    return tuple(values), tuple(loops.values())


def _let_go(robot: RobotSpec, slot: int, loops: Mapping[int, Loop]) -> bool:
    """Return whether a joint's torque loop should run and does not."""
    return robot.slots[slot].held_torque is not None and slot not in loops


def unsettled(state: RobotState, sensing: Sensing) -> list[int]:
    """Return the slots whose joint does not bear the torque that its torque loop asks for."""
    loops = [each for each in state.loops if isinstance(each, TorqueLoop)]
    return [each.slot for each in loops if not each.settled(sensing.numbers)]


def unknown_angle(robot: RobotSpec, stage: StageSpec, sensing: Sensing) -> str:
    """Return which unknown signal the stage's angles depend on, as a reason; empty if none."""
    for write in stage:
        if write.share_of >= 0 and isnan(sensing.numbers[write.share_of]):
            name = robot.vocabulary.numbers[write.share_of]
            return f"{name} is unknown, which the angle for {robot.slots[write.slot].name} needs"
    return ""


def is_done(
    robot: RobotSpec, state: RobotState, motion: Motion, done: CriterionSpec, sensing: Sensing
) -> bool:
    """Whether the stage in force is done; a posture also needs every joint at its angle."""
    if motion.blind or not holds(done, sensing.numbers, state.values, state.loops):
        return False
    return not seekers_away(robot, state, motion, sensing.numbers)


def looped_values(robot: RobotSpec, state: RobotState, sensing: Sensing) -> Numbers:
    """Return the accepted values with the present duty of each loop."""
    values = list(state.values)
    for loop in state.loops:
        resolution = robot.slots[loop.slot].resolution
        values[loop.slot] = quantised(loop.duty(sensing.numbers, sensing.loss), resolution)
    return tuple(values)


def without_loops(state: RobotState) -> Numbers:
    """Return the newest values with zero for every slot that a position loop has driven."""
    driven = state.seeking.difference(
        each.slot for each in state.loops if not ends_with_command(each)
    )
    if not driven:
        return state.latest
    return tuple(0.0 if slot in driven else value for slot, value in enumerate(state.latest))


def _write(
    robot: RobotSpec,
    sensing: Sensing,
    stage: StageSpec,
    values: list[float],
    loops: dict[int, Loop],
) -> None:
    for write in stage:
        slot = robot.slots[write.slot]
        if write.how == "set":
            values[write.slot] = write.value
            loops.pop(write.slot, None)
        elif loop := begun(write, slot, sensing.numbers, loops.get(write.slot)):
            loops[write.slot] = loop
            values[write.slot] = quantised(
                loop.duty(sensing.numbers, sensing.loss), slot.resolution
            )
