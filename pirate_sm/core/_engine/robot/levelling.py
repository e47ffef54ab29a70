"""Bring the part of a robot that turns to an angle against the horizontal, by its accelerometer.

One part holds, clamped; the roll joint turns the other. The direction of gravity is measured while
the robot stands still, in the axes of the pipe: from it follows the roll of the part that holds,
and from that the angle of the roll joint at which the plane of the other part has the angle that is
wanted. The joint turns, the direction is measured again, and the joint corrects itself once.

The roll of a plane is `psi = atan2(-y, z)` (thesis B-13): 0 where it is horizontal, a quarter turn
where it stands upright. The roll joint's angle `phi` is that of the part ahead against the part
behind, so `psi_ahead = psi_behind + phi`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, degrees, hypot, isnan, nan, pi, remainder, tan
from typing import NamedTuple

from pirate_sm.core._engine.moment import has_come
from pirate_sm.core._engine.robot.criteria import AngleSet
from pirate_sm.core._engine.robot.duty_cycles import quantised
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import Levelling, RobotState, confirmed_parts
from pirate_sm.core._engine.sensing import surveyor
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._geometry.space import GRAVITY_M_S2, Vector

MEASURED_FOR_S = 0.5
"""Time over which the direction of gravity is averaged [decided]."""

MOST_TURNS = 2
"""The first turn, and one correction [decided]."""

_LEAST_ACROSS = 0.5
"""Smallest share of gravity across the pipe: in a pipe steeper than 60 deg the roll is too
uncertain [decided]."""

_STILL_RAD = 0.01
"""A roll joint that moves farther than this is not at rest; noise of its sensor is 0.05 deg."""

NOT_MEASURED = "the accelerometer does not show a robot at rest, whose plane could be measured"


class Verdict(NamedTuple):
    """What follows from a measurement: exactly one of these.

    Attributes:
        setpoint_rad: A new angle of the roll joint; NaN for none.
        done: The reason why the command is done.
        failed: The reason why it has failed.
    """

    setpoint_rad: float = nan
    done: str = ""
    failed: str = ""


def levelling_of(robot: RobotSpec, regions: tuple[int, ...], target: int) -> Levelling | None:
    """Return the memory of a command that levels a part; None for other commands.

    Args:
        robot: The robot.
        regions: Regions whose states the command sets.
        target: The configuration that it leads to.
    """
    states = robot.table.configurations[target]
    for region in regions:
        for write in robot.actuation[region][states[region]][-1]:
            if write.how == "level":
                return Levelling(write.slot, write.value)
    return None


def why_not(robot: RobotSpec, state: RobotState, sensing: Sensing, wanted: AngleSet) -> str:
    """Return why no part can be levelled now, before anything moves; empty if it may be possible.

    An unknown direction of gravity prevents nothing: it is measured later.
    """
    if any(state.values[wheel.slot] for wheel in robot.wheels):
        return "impossible: wheels are driven, and the inclination is measured at rest; brake first"
    force = _force(robot, state, sensing)
    return _too_steep([force], wanted) if surveyor.is_gravity(*force) else ""


def measured(
    robot: RobotSpec, state: RobotState, memory: Levelling, sensing: Sensing, now_s: float
) -> Levelling:
    """Return the memory with a new report of the accelerometer; it begins anew in motion.

    Args:
        robot: The robot.
        state: Its state; one part holds.
        memory: The memory so far.
        sensing: What is known now.
        now_s: The time.
    """
    imu = robot.body.imu
    if imu is None:
        return memory
    heard_s = max(
        sensing.heard_s[board.position]
        for board in robot.boards.values()
        if imu.axes[0] in board.number_set
    )
    if heard_s <= memory.heard_s:
        return memory
    force, roll_rad = _force(robot, state, sensing), sensing.numbers[imu.roll]
    memory = memory._replace(heard_s=heard_s)
    if not surveyor.is_gravity(*force) or sensing.doubted.intersection((*imu.axes, imu.roll)):
        return memory._replace(felt=())
    if not memory.felt or not abs(roll_rad - memory.roll_rad) <= _STILL_RAD:
        return memory._replace(felt=(force,), since_s=now_s, roll_rad=roll_rad)
    return memory._replace(felt=(*memory.felt, force))


def judged(
    robot: RobotSpec,
    state: RobotState,
    memory: Levelling,
    sensing: Sensing,
    wanted: AngleSet,
    now_s: float,
) -> Verdict | None:
    """Return what follows from the measurement; None until it has lasted long enough.

    Args:
        robot: The robot.
        state: Its state; one part holds.
        memory: What was measured.
        sensing: What is known now.
        wanted: What is asked of the angle of the roll joint.
        now_s: The time.
    """
    imu, holds = robot.body.imu, confirmed_parts(robot, state)
    if imu is None or not holds or not memory.felt:
        return None
    if not has_come(now_s, memory.since_s + MEASURED_FOR_S):
        return None
    if steep := _too_steep(memory.felt, wanted):
        return Verdict(failed=steep)
    _, side_b, up = (sum(axis) for axis in zip(*memory.felt, strict=True))
    held_rad, roll_rad = atan2(-side_b, up), sensing.numbers[imu.roll]
    behind = robot.body.parts[min(holds)].wheels[0] > imu.link
    turns = 1.0 if behind else -1.0
    off_rad = remainder(held_rad + turns * roll_rad - memory.target_rad, pi)
    if memory.turns and abs(off_rad) <= wanted.within:
        return Verdict(done=f"{degrees(off_rad):z.1f} deg off, as the accelerometer shows")
    if memory.turns >= MOST_TURNS:
        off = f"still {abs(degrees(off_rad)):.1f} deg off after a correction"
        return Verdict(failed=f"{off}, more than {degrees(wanted.within):g} deg")
    return _turned(robot, memory.slot, turns * (memory.target_rad - held_rad), roll_rad)


def _turned(robot: RobotSpec, slot: int, wanted_rad: float, roll_rad: float) -> Verdict:
    """Return the setpoint nearest to the roll joint's angle that shows the wanted plane.

    A half turn shows the same plane, so there are two candidates around the present angle.
    """
    spec = robot.slots[slot]
    nearest = roll_rad + remainder(wanted_rad - roll_rad, pi)
    other = nearest + (pi if nearest < roll_rad else -pi)
    for angle_rad in (nearest, other):
        if spec.low <= angle_rad <= spec.high:
            return Verdict(quantised(angle_rad, spec.resolution))
    name = robot.vocabulary.numbers[spec.angle]
    return Verdict(
        failed=f"impossible: {name} would have to turn to {degrees(nearest):z.1f} or"
        f" {degrees(other):z.1f} deg, and turns to ±{degrees(spec.high):g} deg at most"
    )


def _force(robot: RobotSpec, state: RobotState, sensing: Sensing) -> Vector:
    """Return the specific force in the axes of the pipe, in the plane of the part that holds."""
    parts = confirmed_parts(robot, state)
    part = min(parts, default=-1)
    return surveyor.force_in_pipe(part, sensing.numbers, *robot.body.rows)


def _too_steep(felt: Sequence[Vector], wanted: AngleSet) -> str:
    """Return why the roll is too uncertain in so steep a pipe; empty where it is not.

    A part that turns sideways out of the pipe's axis by a small angle shows a roll that is wrong by
    that angle times the tangent of the slope.
    """
    along, side_b, up = (sum(axis) / len(felt) for axis in zip(*felt, strict=True))
    across = hypot(side_b, up)
    if isnan(across):
        return ""
    slope_rad = abs(atan2(along, across))
    steep = f"impossible: the pipe is {degrees(slope_rad):z.0f} deg steep here"
    if across < _LEAST_ACROSS * GRAVITY_M_S2:
        return f"{steep}, and in more than 60 deg gravity shows no roll"
    unsure_rad = wanted.leaning * tan(slope_rad)
    if unsure_rad <= wanted.within:
        return ""
    return (
        f"{steep}; a part that leans by {degrees(wanted.leaning):g} deg in it shows its roll to"
        f" {degrees(unsure_rad):z.1f} deg only, and {degrees(wanted.within):g} deg are asked for"
    )
