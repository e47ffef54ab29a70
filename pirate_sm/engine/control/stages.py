"""What a stage of a command's actuation writes, and whether that has been reached.

A command that has a posture takes it first, in the stage ``POSTURE``; then come the stages of the
states that it leads to.
"""

from __future__ import annotations

from math import isnan

from pirate_sm.engine.control.position_loop import Loop
from pirate_sm.engine.robot.command_spec import StageSpec
from pirate_sm.engine.robot.criteria import CriterionSpec
from pirate_sm.engine.robot.done import holds
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import (
    POSTURE,
    Motion,
    Numbers,
    RobotState,
    known_values,
    posture_of,
)
from pirate_sm.engine.sensing.known_signals import Sensing


def stage_array(
    robot: RobotSpec,
    state: RobotState,
    motion: Motion,
    sensing: Sensing,
    regions: tuple[int, ...],
    stage: int,
) -> tuple[Numbers, tuple[Loop, ...]]:
    """Return the array that puts a stage of the regions' states in force, and its position loops.

    A posture that needs an unknown angle changes nothing.
    """
    target = robot.table.configurations[motion.target]
    values = list(known_values(state.latest, sensing.numbers, robot))
    loops: list[Loop] = []
    posture = posture_of(robot, motion) if stage == POSTURE else None
    if posture is not None:
        if not motion.blind:
            _write(robot, sensing, posture.writes, values, loops)
        return tuple(values), tuple(loops)
    for region in regions:
        stages = robot.actuation[region][target[region]]
        _write(robot, sensing, stages[min(stage, len(stages) - 1)], values, loops)
    return tuple(values), tuple(loops)


def unknown_angle(robot: RobotSpec, stage: StageSpec, sensing: Sensing) -> str:
    """Return why the stage's angles cannot be told: which signal is unknown; empty: they can."""
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
    return not _away(robot, state, motion, sensing)


def _away(robot: RobotSpec, state: RobotState, motion: Motion, sensing: Sensing) -> list[str]:
    """Return the joints that are not at the angle which the posture under way gives them."""
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    if posture is None:
        return []
    names, numbers = robot.vocabulary.numbers, sensing.numbers
    return [
        names[loop.angle]
        for loop in state.loops
        if not (
            loop.arrived(numbers)
            or abs(loop.target_rad - numbers[loop.angle]) <= posture.within_rad
        )
    ]


def why_late(robot: RobotSpec, state: RobotState, motion: Motion, sensing: Sensing) -> str:
    """Return what was not done in time."""
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    if posture is None:
        return f"not done within {motion.timeout_s:g} s"
    away = _away(robot, state, motion, sensing)
    what = f"{', '.join(away)} not at the angle" if away else "its sign was not seen"
    return f"not in the posture '{posture.name}' within {motion.timeout_s:g} s: {what}"


def looped_values(robot: RobotSpec, state: RobotState, sensing: Sensing) -> Numbers:
    """Return the values in force with the present duty of each position loop."""
    values = list(state.values)
    for loop in state.loops:
        resolution = robot.slots[loop.slot].resolution
        values[loop.slot] = _quantised(loop.duty(sensing.numbers, sensing.loss), resolution)
    return tuple(values)


def without_loops(state: RobotState) -> Numbers:
    """Return the values in force, with zero for every slot that a position loop has driven."""
    if not state.seeking:
        return state.values
    return tuple(0.0 if slot in state.seeking else value for slot, value in enumerate(state.values))


def _write(
    robot: RobotSpec, sensing: Sensing, stage: StageSpec, values: list[float], loops: list[Loop]
) -> None:
    for write in stage:
        slot = robot.slots[write.slot]
        if write.how == "set":
            values[write.slot] = write.value
        elif write.how == "seek" and slot.loop is not None:
            share = 1.0 if write.share_of < 0 else sensing.numbers[write.share_of]
            target_rad = write.value * share
            loop = Loop(write.slot, slot.angle, slot.rate, slot.torque, slot.loop, target_rad)
            loops.append(loop)
            duty = loop.duty(sensing.numbers, sensing.loss)
            values[write.slot] = _quantised(duty, slot.resolution)


def _quantised(value: float, resolution: float) -> float:
    return round(value / resolution) * resolution
