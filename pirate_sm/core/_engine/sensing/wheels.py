"""Judge wheels: which of them odometry believes, and whether they roll or slip.

A driven wheel that neither turns nor bears the force of its motor is dead, or its sensor is. One
that strays from the others spins, sticks or is silent. What such a wheel has shown since it began
is taken out of the odometry again. It is believed again once it has turned with the others.

A wheel slips only with the friction of its wall along its rim, so slip shows in the forces. If the
wheels together give what gravity asks for and all turn alike, they roll: wheels that slip turn as
fast as their loads let them, and these differ. Wheels that give more push against something; while
they give less the robot slides. What resists the rolling of tyres is neither. Dead wheels may hold
the robot with any force up to their drag.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from math import inf, isnan, nan, sin
from statistics import fmean, median
from typing import NamedTuple

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.board_spec import WheelSpec
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.sensing.traction import normal_forces
from pirate_sm.core._geometry.space import GRAVITY_M_S2
from pirate_sm.core.effects import Environment

# --- which wheels odometry believes -----------------------------------------------------------


_STILL, _LIMP = 0.05, 0.5
"""A limp wheel has less than these shares of the speed and of the force of its duty [decided]."""

_LIMP_S = 0.3
"""A wheel that is limp for so long is not believed [decided]: three rounds of the boards."""

_STRAYED_M, _FORGET_S = 0.025, 2.0
"""Neither is one that is so far from the others, of which it forgets all in this time [decided]."""

_TOGETHER_M, _TOGETHER, _AGAIN_S = 0.002, 0.1, 1.0
"""A wheel turns with the others up to this way and this share of theirs in a round; after that time
it is believed again [decided]."""


class Believed(NamedTuple):
    """What the wheels have rolled in a round.

    Attributes:
        wheels: Places of the wheels that count.
        moved_m: How far they have rolled.
        missed_m: What odometry lacks, because it has counted wheels that are not believed any more.
        strayed_m: Per wheel how far it is from the others lately; NaN while it does not count.
        odd_s: Per wheel since when it is limp, or turns with the others again; infinite otherwise.
        out: The wheels that are not believed.
    """

    wheels: tuple[int, ...]
    moved_m: float
    missed_m: float
    strayed_m: tuple[float, ...]
    odd_s: tuple[float, ...]
    out: frozenset[int]


def believed(
    robot: RobotSpec, sensing: Sensing, setpoints: Numbers, rolled_m: Sequence[float], now_s: float
) -> Believed:
    """Return what the wheels have rolled in a round, by those that are believed.

    Args:
        robot: The robot.
        sensing: The signals, with what is remembered of the round before.
        setpoints: In force, per slot.
        rolled_m: What each wheel has rolled in this round; NaN is unknown.
        now_s: When the round ends.
    """
    memory = sensing.distance
    silent_s = now_s - robot.link.silent_after_s
    heard_s = [sensing.heard_s[board] for board in robot.wheel_boards]
    heard = [
        at
        for at, share in enumerate(sensing.shares)
        if share and not isnan(rolled_m[at]) and heard_s[at] > silent_s
    ]
    # What one has rolled while it was silent is not of this round.
    counted = [at for at in heard if not isnan(memory.strayed_m[at])]
    mean_m = fmean([rolled_m[at] for at in counted]) if counted else 0.0
    kept = max(0.0, 1.0 - (now_s - memory.at_s) / _FORGET_S)
    strayed = [0.0 if at in heard else nan for at in range(len(rolled_m))]
    for at in counted:
        strayed[at] = memory.strayed_m[at] * kept + rolled_m[at] - mean_m
    limp = {w.place for w in robot.wheels if _is_limp(w, sensing, setpoints[w.slot])}
    odd = limp & set(counted)
    odd |= {at for at in memory.out if _turns_along(rolled_m[at], mean_m)}
    odd_s = [min(since_s, now_s) if at in odd else inf for at, since_s in enumerate(memory.odd_s)]
    able = [at for at in counted if at not in odd]
    far = _far(robot, sensing, {at: strayed[at] for at in able}, now_s) if len(able) > 2 else set()
    lost = {at for at in counted if now_s - odd_s[at] >= _LIMP_S} | far
    if not lost < set(counted):
        lost = set()
    again = {at for at in memory.out if now_s - odd_s[at] >= _AGAIN_S}
    wheels = tuple(at for at in counted if at not in lost)
    missed_m = fmean([strayed[at] for at in wheels]) if lost else 0.0
    return Believed(
        wheels,
        mean_m + missed_m,
        missed_m,
        tuple(each - missed_m if at in wheels else each for at, each in enumerate(strayed)),
        tuple(inf if at in lost | again else since_s for at, since_s in enumerate(odd_s)),
        (memory.out | lost) - again,
    )


def _is_limp(wheel: WheelSpec, sensing: Sensing, duty: float) -> bool:
    """Return whether a driven wheel neither turns nor bears force."""
    speed_m_s = abs(sensing.numbers[wheel.speed] * wheel.metres_per_rad)
    still = speed_m_s < _STILL * abs(duty) * wheel.top_m_s
    return still and not wheel.force_n(sensing.numbers) > _LIMP * abs(duty) * wheel.stall_n


def _far(
    robot: RobotSpec, sensing: Sensing, strayed_m: Mapping[int, float], now_s: float
) -> set[int]:
    """Return the wheels that are far from the others, wherever all are by now.

    Since its last report a wheel may have rolled on with the others, or have stopped.
    """
    late_m = _late(robot, sensing, strayed_m, now_s, robot.link.silent_after_s / 4)
    least = {at: each + min(0.0, late_m[at]) for at, each in strayed_m.items()}
    most = {at: each + max(0.0, late_m[at]) for at, each in strayed_m.items()}
    low_m, high_m = median(least.values()) - _STRAYED_M, median(most.values()) + _STRAYED_M
    return {at for at in strayed_m if most[at] < low_m or least[at] > high_m}


def _late(
    robot: RobotSpec, sensing: Sensing, wheels: Collection[int], now_s: float, most_s: float = inf
) -> dict[int, float]:
    """Return per wheel how far it has rolled since its last report if it turns as these do, m.

    Args:
        robot: The robot.
        sensing: The signals.
        wheels: Places of the wheels.
        now_s: When it is.
        most_s: Of an older report only so much counts.
    """
    speeds = [
        sensing.numbers[robot.wheels[at].speed] * robot.wheels[at].metres_per_rad for at in wheels
    ]
    pace_m_s = median([each for each in speeds if not isnan(each)] or [0.0])
    heard_s = {at: sensing.heard_s[robot.wheel_boards[at]] for at in wheels}
    return {at: pace_m_s * min(now_s - heard_s[at], most_s) for at in wheels}


def _turns_along(rolled_m: float, others_m: float) -> bool:
    off_m = abs(rolled_m - others_m)
    return abs(others_m) > _TOGETHER_M and off_m <= _TOGETHER_M + _TOGETHER * abs(others_m)


# --- whether they roll or slip ----------------------------------------------------------------


_LEANING = 0.2
"""Wheels that lean show up to this share more than the robot moves [measured]."""

_ALIKE = 0.04
"""Wheels turn alike whose speeds differ by less than this share of the largest: one count of the
encoder is 1 % of it in a round [decided]."""

BALANCED = 0.25
"""Forces are balanced up to this share of the weight; those of wheels that roll up to 0.14
[measured]."""

_EVEN, _NOISE = 0.3, 0.015
"""The wheels of a part share its force evenly up to the first share; that of the outer ones is a
quarter of that of the middle one while they slip. The second is of the top speed or the stall
force, two counts of the encoder [decided]."""

_SPREAD = 0.05
"""A motor may turn faster than its profile says by this share of its top speed [assumed]."""

_WITH = 0.1
"""A wheel turns with the others whose speed differs from theirs by up to this share [decided]."""

_RESISTS = 0.03
"""Tyres may resist rolling by up to this share of what they press with: rubber on a hard wall
[assumed]."""

_FEW = 3
"""So many wheels press differently, so that they do not turn alike while they slip."""


class WheelGrip(NamedTuple):
    """Whether wheels may slip.

    Attributes:
        slips: Whether all of them may.
        speeds: Speeds that the robot may have besides the mean of its wheels; none if they roll.
        pull_m_s2: How fast it accelerates at most if it slides down a slope.
        vague: Whether that is decided by what follows, because boards have repeated their values.
    """

    slips: bool = False
    speeds: Sequence[float] = ()
    pull_m_s2: float = 0.0
    vague: bool = False


def judge_grip(
    robot: RobotSpec,
    sensing: Sensing,
    setpoints: Numbers,
    by: Believed,
    pitch_rad: float,
    held: Collection[int] = (),
) -> WheelGrip:
    """Return whether the wheels may slip, by what they have shown in a round.

    Args:
        robot: The robot.
        sensing: The signals.
        setpoints: The active ones, per slot.
        by: What the wheels have rolled in the round.
        pitch_rad: By how much the pipe climbs; NaN is unknown.
        held: The parts that are clamped.
    """
    numbers, weight_n = sensing.numbers, robot.body.weight_n
    driven = [wheel for wheel in robot.wheels if setpoints[wheel.slot]]
    if not driven:
        return WheelGrip()
    heard = _heard(robot, sensing, driven)
    turning = [
        wheel
        for wheel in heard
        if wheel.place in by.wheels
        and by.odd_s[wheel.place] == sensing.distance.odd_s[wheel.place] == inf
    ]
    speeds = [numbers[wheel.speed] * wheel.metres_per_rad for wheel in turning]
    bearing = turning + [w for w in _along(numbers, heard, speeds) if w not in turning]
    drag_n = sum(wheel.drag_n for wheel in driven if wheel not in bearing)
    slack_n = BALANCED * weight_n + drag_n
    # Currents have no sign. A wheel that turns faster than its duty asks for is pushed.
    forces_n = [wheel.force_n(numbers) for wheel in bearing]
    pushed = [wheel.is_pushed(numbers, setpoints) for wheel in bearing]
    signed_n = sum(-n if back else n for n, back in zip(forces_n, pushed, strict=True))
    asked_n = weight_n if isnan(pitch_rad) else abs(weight_n * sin(pitch_rad))
    felt = robot.body.imu is not None
    if not felt:  # whether the pipe climbs, only its wheels show, and a slide nothing
        asked_n = min(weight_n, abs(signed_n))
    excess_n = min(sum(forces_n) - asked_n, abs(signed_n) - asked_n, key=abs)
    top_m_s = max(wheel.top_m_s for wheel in driven)
    ends = (min(speeds), max(speeds)) if speeds else (0.0, top_m_s)
    unalike = ends[1] - ends[0] > _ALIKE * top_m_s
    pushes, lacks = excess_n > slack_n, excess_n < -slack_n and not isnan(pitch_rad)
    sinks = lacks and fmean(speeds or [0.0]) * pitch_rad < 0  # what resists holds it back, too
    resisted = (pushes or sinks) and abs(excess_n) - slack_n <= _RESISTS * _pressed_n(
        robot, sensing, setpoints, pitch_rad, held
    )
    # A loop keeps its wheel at a speed; then loads show in the duties.
    if (drag_n or resisted) and turning:
        duties = [abs(setpoints[wheel.slot]) for wheel in turning]
        unalike |= max(duties) - min(duties) > _ALIKE
    steep = felt and asked_n + drag_n > BALANCED * weight_n
    slips = (pushes or lacks) and not resisted
    slips |= steep and (unalike or len(turning) < _FEW)
    if not slips and not unalike:
        return WheelGrip()
    gripping = _gripping(robot, numbers, turning, setpoints)
    if not gripping and pushes and felt and not steep:
        gripping = _carried(numbers, setpoints, turning)
    if gripping or not slips:
        return WheelGrip(speeds=gripping or ends)
    pull_n = min(asked_n, slack_n - excess_n) if steep and weight_n else 0.0
    vague = len(turning) < _FEW <= len(by.wheels)
    return WheelGrip(True, ends, pull_n / weight_n * GRAVITY_M_S2 if pull_n else 0.0, vague)


def _heard(robot: RobotSpec, sensing: Sensing, wheels: Iterable[WheelSpec]) -> list[WheelSpec]:
    """Return the wheels whose speeds their boards have reported in the last period."""
    recent_s = sensing.distance.at_s - robot.link.period_s
    return [
        wheel
        for wheel in wheels
        if not isnan(sensing.numbers[wheel.speed])
        and sensing.heard_s[robot.wheel_boards[wheel.place]] > recent_s
    ]


def _pressed_n(
    robot: RobotSpec,
    sensing: Sensing,
    setpoints: Numbers,
    pitch_rad: float,
    held: Collection[int],
) -> float:
    """Return how hard all wheels press; 0 where it is unknown."""
    if robot.traction is None:
        return 0.0
    around = Environment("", nan, pitch_rad, nan)
    part = min(held, default=-1)
    each_n = normal_forces(robot, robot.traction, sensing.numbers, setpoints, part, around)
    return 0.0 if isnan(sum(each_n)) else sum(max(0.0, each) for each in each_n)


def _carried(numbers: Numbers, setpoints: Numbers, turning: Sequence[WheelSpec]) -> list[float]:
    """Return the speeds that a robot may have which turns one of its wheels; none if it may not.

    A motor that slips bears less force the faster it turns. So the fastest wheel, if it turns
    faster than without load and bears more force than a slower one, is turned by the wall, and the
    robot moves with it. Wheels that lean push against each other then without slip along the pipe.
    """
    if not turning:
        return []
    fastest = max(turning, key=lambda wheel: abs(numbers[wheel.speed]))
    speed_m_s = numbers[fastest.speed] * fastest.metres_per_rad
    free_m_s = (abs(setpoints[fastest.slot]) + _SPREAD) * fastest.top_m_s
    least_n = min(wheel.force_n(numbers) for wheel in turning) + 0.5 * _NOISE * fastest.stall_n
    if abs(speed_m_s) <= free_m_s or not fastest.force_n(numbers) > least_n:
        return []
    speeds = [numbers[wheel.speed] * wheel.metres_per_rad for wheel in turning]
    return [(1 - _LEANING) * speed_m_s, min(speeds), max(speeds)]


def _along(
    numbers: Numbers, heard: Sequence[WheelSpec], speeds: Sequence[float]
) -> list[WheelSpec]:
    """Return the wheels that turn with the others, whether their ways are believed or not.

    Their motors turn them, or the robot does while it moves. So none of them holds back a robot
    whose other wheels slip, as a dead wheel may.
    """
    if not speeds:
        return []
    mean_m_s = fmean(speeds)
    return [
        wheel
        for wheel in heard
        if abs(numbers[wheel.speed] * wheel.metres_per_rad - mean_m_s) <= _WITH * abs(mean_m_s)
    ]


def _gripping(
    robot: RobotSpec, numbers: Numbers, turning: Sequence[WheelSpec], setpoints: Numbers
) -> list[float]:
    """Return the speed of each part whose wheels roll.

    They press differently on the wall, so while they slip their forces differ, and their speeds by
    what these take from them.
    """
    found = []
    for part in robot.body.parts:
        own = [wheel for wheel in turning if wheel.place in part.wheels]
        if len(own) < _FEW:
            continue
        speeds = [numbers[wheel.speed] * wheel.metres_per_rad for wheel in own]
        forces_n = [wheel.force_n(numbers) for wheel in own]
        slowest_m_s = min(map(abs, speeds))
        lost_m_s = max(w.top_m_s * abs(setpoints[w.slot]) for w in own) - slowest_m_s
        noise_m_s = _NOISE * max(wheel.top_m_s for wheel in own)
        noise_n = _NOISE * max(wheel.stall_n for wheel in own)
        alike = max(speeds) - min(speeds) <= _EVEN * max(0.0, lost_m_s) + noise_m_s
        if alike and max(forces_n) - min(forces_n) <= _EVEN * max(forces_n) + 2 * noise_n:
            found.append(fmean(speeds))
    return found
