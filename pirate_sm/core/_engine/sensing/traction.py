"""Estimate body speed, slip, normal forces and friction from the signals of a frame.

The speed of the body is what somebody outside measures. Without that it is the median of the rim
speeds that agree with each other; a slip that all wheels have in common does not show in it, so
slip and friction are unknown then.

A wheel's friction is the least-squares fit F = mu N over the frames in which it slips steadily, in
the way that it is driven, and its motor is not at its limit; F is what the motor gives less what
resists the rolling of the tyre. Old frames are forgotten by degrees. At other times it is unknown;
the friction that is used is then a lower bound of it.

The estimates cost as much as a frame of a board. They are made in every round where a condition, a
criterion or a grip reads one of them, or while there is something to remember; else when somebody
asks for them (:meth:`pirate_sm.core._engine.engine.Engine.numbers`).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import copysign, cos, inf, isnan, nan, sin
from statistics import median

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.board_spec import BoardSpec, TractionSpec, WheelTraction
from pirate_sm.core._engine.sensing.known_signals import (
    Sensing,
    Slip,
    Slipping,
    Traction,
    lengthened,
    slip_between,
)
from pirate_sm.core._geometry.chain import ChainLoads, couples_nm, normal_forces_n
from pirate_sm.core._geometry.space import GRAVITY_M_S2, Vector
from pirate_sm.core.effects import Environment

FORGETTING = 0.97
"""What a frame leaves of the weight of all those before it (design: 0.97)."""

AT_LIMIT = 0.95
"""A motor that gives a larger share of its stall torque may be what limits the force [decided]."""


def with_traction(
    robot: RobotSpec,
    spec: TractionSpec,
    sensing: Sensing,
    setpoints: Numbers,
    configuration: int,
    around: Environment,
    now_s: float,
) -> Sensing:
    """Return the signals with those of traction, and what is remembered of it.

    Normal forces need every board, so all of it is made once in a round: with the last wheel.

    Args:
        robot: The robot.
        spec: Its signals of traction.
        sensing: What is known.
        setpoints: In force, per slot.
        configuration: Index of the configuration; the pipe lies along the parts that it holds.
        around: The pipe around the robot.
        now_s: When it is.
    """
    numbers, held = list(sensing.numbers), min(robot.held[configuration], default=-1)
    normal_n = normal_forces(robot, spec, numbers, setpoints, held, around)
    traction = estimate(spec, sensing.traction, numbers, setpoints, normal_n, now_s)
    return sensing._replace(numbers=tuple(numbers), traction=traction)


def measured_outside(
    spec: TractionSpec | None, traction: Traction, index: int, value: float, now_s: float
) -> Traction:
    """Return what is to be remembered of a number that was measured outside."""
    if spec is None or index != spec.measured:
        return traction
    since_s = now_s - spec.averages_s
    return traction._replace(readings=lengthened(traction.readings, value, now_s, since_s))


def rolled(spec: TractionSpec, sensing: Sensing, board: BoardSpec, now_s: float) -> Sensing:
    """Return the signals with the slip of a board's wheels after its frame."""
    numbers, rims = list(sensing.numbers), list(sensing.traction.rims)
    own = [at for at, wheel in enumerate(spec.wheels) if wheel.board == board.position]
    for at in own:
        rim_m_s = numbers[spec.wheels[at].speed] * spec.wheels[at].metres_per_rad
        rims[at] = lengthened(rims[at], rim_m_s, now_s)
    traction = sensing.traction._replace(rims=tuple(rims))
    for at in own:
        _put_slip(spec.wheels[at], _slip(spec, traction, numbers, at), numbers)
    return sensing._replace(numbers=tuple(numbers), traction=traction)


def _slip(spec: TractionSpec, traction: Traction, numbers: Sequence[float], at: int) -> Slip:
    """Return the slip of a wheel; unknown while its own speed or that of the body is."""
    if spec.measured < 0 or isnan(numbers[spec.measured] + numbers[spec.wheels[at].speed]):
        return Slip()
    return slip_between(traction.rims[at], traction.readings, spec.delay_s)


def _put_slip(wheel: WheelTraction, slip: Slip, numbers: list[float]) -> None:
    known = abs(slip.body_m_s) >= wheel.unknown_below_m_s and slip.body_m_s != 0
    _put(numbers, wheel.slip_speed, slip.slip_m_s)
    _put(numbers, wheel.slip, -slip.slip_m_s / slip.body_m_s if known else nan)


def estimate(
    spec: TractionSpec,
    before: Traction,
    numbers: list[float],
    setpoints: Numbers,
    normal_n: Numbers,
    now_s: float,
) -> Traction:
    """Fill in the signals of traction; return what is to be remembered.

    Args:
        spec: The signals.
        before: What was remembered.
        numbers: All signals, SI; changed in place.
        setpoints: In force, per slot.
        normal_n: Normal force of each wheel; NaN is unknown.
        now_s: When it is.
    """
    measured_m_s = numbers[spec.measured] if spec.measured >= 0 else nan
    if spec.robot_speed >= 0:
        numbers[spec.robot_speed] = _robot_speed(spec, numbers, measured_m_s)
    slips = [_slip(spec, before, numbers, at) for at in range(len(spec.wheels))]
    slipping = tuple(
        _wheel(wheel, old, pressed_n, numbers, setpoints[wheel.slot], slip, now_s)
        for wheel, old, pressed_n, slip in zip(
            spec.wheels, before.slipping, normal_n, slips, strict=True
        )
    )
    for target, sources in spec.least:
        known = [numbers[source] for source in sources if not isnan(numbers[source])]
        numbers[target] = min(known, default=nan)
    return before._replace(slipping=slipping)


def _robot_speed(spec: TractionSpec, numbers: Sequence[float], measured_m_s: float) -> float:
    """Return the speed from outside, else the median of the wheels that agree; NaN without."""
    if not isnan(measured_m_s):
        return measured_m_s
    speeds = [numbers[wheel.speed] * wheel.metres_per_rad for wheel in spec.rolling]
    known = [speed for speed in speeds if not isnan(speed)]
    if not known:
        return nan
    middle = median(known)
    agree = [speed for speed in known if abs(speed - middle) <= spec.agreeing_m_s]
    return median(agree) if 2 * len(agree) > len(known) else nan


def _wheel(
    wheel: WheelTraction,
    before: Slipping,
    normal_n: float,
    numbers: list[float],
    setpoint: float,
    slip: Slip,
    now_s: float,
) -> Slipping:
    """Fill in the signals of one wheel; return what is remembered of its slipping."""
    slip_m_s = slip.slip_m_s
    torque = torque_nm(wheel, numbers, setpoint)
    force_n = torque / wheel.metres_per_rad - _resisting_n(wheel, normal_n, numbers)
    _put_slip(wheel, slip, numbers)
    _put(numbers, wheel.normal_force, normal_n)
    _put(numbers, wheel.friction_used, abs(force_n) / normal_n if normal_n > 0 else nan)
    way = setpoint * wheel.metres_per_rad
    slips = way * slip_m_s > 0 and abs(slip_m_s) > wheel.slip_above_m_s
    limited = not abs(torque) < AT_LIMIT * wheel.stall_nm
    if isnan(slip_m_s) and now_s - before.seen_s <= wheel.steady_s:
        _put(numbers, wheel.friction, nan)
        return before  # a frame without a value, or a ruler that is silent for a moment
    after = Slipping()
    if slips:
        after = before if before.since_s < inf else Slipping(now_s)
        after = after._replace(seen_s=now_s)
        if normal_n > 0 and not limited and now_s - after.since_s >= wheel.steady_s:
            after = after._replace(
                force_normal=FORGETTING * after.force_normal + abs(force_n) * normal_n,
                normal_squared=FORGETTING * after.normal_squared + normal_n * normal_n,
            )
    weight = after.normal_squared
    _put(numbers, wheel.friction, after.force_normal / weight if weight > 0 else nan)
    return after


def _resisting_n(wheel: WheelTraction, normal_n: float, numbers: Sequence[float]) -> float:
    """Return what a turning tyre takes of its motor's force along the pipe; 0 while it stands."""
    ahead_m_s = numbers[wheel.speed] * wheel.metres_per_rad
    return copysign(wheel.resists * normal_n, ahead_m_s) if abs(ahead_m_s) > 0 else 0.0


def _put(numbers: list[float], target: int, value: float) -> None:
    if target >= 0:
        numbers[target] = value


def torque_nm(wheel: WheelTraction, numbers: Sequence[float], duty: float) -> float:
    """Return the torque of a motor with the sign that a current does not show.

    It is that of ``duty - speed / no-load speed``: a wheel that is dragged turns faster than its
    duty asks for, and its motor holds it back.
    """
    if wheel.torque < 0:
        return nan
    if duty == 0:
        return 0.0 * numbers[wheel.torque]
    return copysign(numbers[wheel.torque], duty - numbers[wheel.speed] / wheel.no_load_rad_s)


def normal_forces(
    robot: RobotSpec,
    spec: TractionSpec,
    numbers: Sequence[float],
    setpoints: Numbers,
    held: int,
    around: Environment,
) -> Numbers:
    """Return the normal force of each wheel by chain statics; NaN where it is unknown."""
    if held < 0 or isnan(around.pitch_rad):
        return (nan,) * len(spec.wheels)
    body = robot.body
    turn_rad = body.heading_in_pipe(numbers, held, 0)
    headings = body.headings(body.angles(numbers), 0, turn_rad)
    torques = [torque_nm(wheel, numbers, setpoints[wheel.slot]) for wheel in spec.wheels]
    joints = [numbers[joint] if joint >= 0 else 0.0 for joint in spec.joint_torques]
    drives = [t / wheel.metres_per_rad for t, wheel in zip(torques, spec.wheels, strict=True)]
    braked = [setpoints[wheel.slot] == 0 for wheel in spec.wheels]
    couples = couples_nm(joints, torques, spec.mounts)
    loads = ChainLoads(headings, couples, drives, braked, gravity_m_s2(around)[:2])
    pressed_n = normal_forces_n(body.lengths_m, spec.masses_kg, body.sides, loads)
    if any(wheel.resists for wheel in spec.wheels):
        # What resists goes by these forces; the walls get the rest of what the motors give.
        left_n = [
            drive_n - _resisting_n(wheel, max(0.0, each_n), numbers)
            for wheel, drive_n, each_n in zip(spec.wheels, drives, pressed_n, strict=True)
        ]
        less = loads._replace(drives_n=left_n)
        pressed_n = normal_forces_n(body.lengths_m, spec.masses_kg, body.sides, less)
    return tuple(pressed_n)


def gravity_m_s2(around: Environment) -> Vector:
    """Return gravity along the pipe, towards side A and along the normal of the held part.

    It pulls back where the pipe climbs, and to side B where the robot rolls that way (B-13).
    """
    roll_rad = 0.0 if isnan(around.roll_rad) else around.roll_rad
    down_m_s2 = GRAVITY_M_S2 * cos(around.pitch_rad)
    return (
        -GRAVITY_M_S2 * sin(around.pitch_rad),
        -down_m_s2 * sin(roll_rad),
        down_m_s2 * cos(roll_rad),
    )
