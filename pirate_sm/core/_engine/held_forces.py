"""Between which values the normal forces of a clamped robot lie, by its signals at a moment."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, radians, remainder, sqrt

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.traction import gravity_m_s2, torque_nm
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._geometry.chain import Pose, in_space
from pirate_sm.core._geometry.force_intervals import (
    ForceInterval,
    Posture,
    Touch,
    normal_force_intervals,
)
from pirate_sm.core._geometry.space import DRAWING, Vector, crossed, dot, scaled

CURRENT_ERROR = 0.05
"""By this share of its stall torque a driven motor may give another torque than its current shows
[assumed]."""

_ASKEW_RAD = radians(20.0)
"""A part that leans more against the others lies in another leg: loose in the widest shipped pipe
one leans by up to 14 degrees (72 mm of room over the 280 mm between its outer wheels)."""


def held_force_intervals(
    robot: RobotSpec,
    state: EngineState,
    friction: float,
    brakes_nm: Sequence[float],
    *,
    resists: float,
    is_round: bool,
) -> tuple[tuple[int, ...], tuple[ForceInterval, ...]]:
    """Return the wheels of the parts that hold, and the interval of each and last of their sum.

    The pipe lies along the parts that hold. A wheel of a part that does not hold bears what it must
    across the pipe, nothing along it. Both are empty where no part holds, where the robot lies in a
    bend, whose walls are not in the program, or where too little is known.

    Args:
        robot: The robot.
        state: What is known of it.
        friction: Static friction coefficient of its wheels.
        brakes_nm: What each wheel bears at duty 0.
        resists: Force that resists the rolling of a tyre, over the normal force.
        is_round: Whether the pipe is round; else it is a pair of bars.

    Raises:
        UsageError: SciPy is not installed.
    """
    numbers, setpoints = state.sensing.shown, state.robot.values
    spec, body, around = robot.traction, robot.body, state.surveyed.reported
    parts = sorted(robot.held[state.robot.configuration])
    if spec is None or not parts:
        return (), ()
    wheels = tuple(wheel for part in parts for wheel in body.parts[part].wheels)
    heading_rad = body.heading_in_pipe(numbers, parts[0], 0)
    others = (body.heading_in_pipe(numbers, part, 0) for part in range(len(body.parts)))
    if any(abs(remainder(other - heading_rad, 2 * pi)) > _ASKEW_RAD for other in others):
        return (), ()
    places = body.places(body.angles(numbers), 0, Pose(0.0, 0.0, heading_rad))
    link = body.roll_link if is_round and body.roll >= 0 else -1
    roll_rad = numbers[body.roll] if link >= 0 else 0.0
    chain = in_space(places, DRAWING, wheel=wheels[0], link=link, roll_rad=roll_rad)
    touches: list[Touch] = []
    for at, wheel in enumerate(spec.wheels):
        normal = (chain.front if at <= link else chain.rear).normal
        across = crossed(normal, DRAWING.ahead)
        side = scaled(body.sides[at] / sqrt(dot(across, across)), across)
        if at in wheels:
            braked = setpoints[wheel.slot] == 0
            doubt_nm = brakes_nm[at] if braked else CURRENT_ERROR * wheel.stall_nm
            drive_nm = torque_nm(wheel, numbers, setpoints[wheel.slot])
            along_n = _between(wheel.metres_per_rad, drive_nm, doubt_nm)
            inward = scaled(-1.0, side)
            wall = (inward, DRAWING.ahead, along_n, friction, resists)
            touches.append(Touch(at, spec.mounts[at], *wall))
        else:
            touches += _loose(at, spec.mounts[at], side)
    posture = Posture(
        chain.points,
        [(chain.front if at <= link else chain.rear).normal for at in range(len(places))],
        {at: numbers[joint] for at, joint in enumerate(spec.joint_torques) if joint >= 0},
        [scaled(mass_kg, gravity_m_s2(around)) for mass_kg in spec.masses_kg],
        touches,
        body.wheel_radius_m,
        is_round,
    )
    return (wheels, normal_force_intervals(posture, wheels)) if posture.is_known else ((), ())


def _between(metres_per_rad: float, torque_nm: float, doubt_nm: float) -> tuple[float, float]:
    """Return the least and the greatest force along the pipe, by a torque and its error."""
    force_n, doubt_n = torque_nm / metres_per_rad, doubt_nm / abs(metres_per_rad)
    return force_n - doubt_n, force_n + doubt_n


def _loose(wheel: int, link: int, side: Vector) -> tuple[Touch, ...]:
    """Return touches by which a wheel bears any force across the pipe, and none along it."""
    ways = (side, crossed(side, DRAWING.ahead))
    return tuple(
        Touch(wheel, link, scaled(sign, way), DRAWING.ahead, (0.0, 0.0), 0.0)
        for way in ways
        for sign in (1.0, -1.0)
    )
