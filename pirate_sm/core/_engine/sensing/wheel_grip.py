"""Judge whether wheels roll or slip, by the forces that they bear and how fast they turn.

A wheel slips only with the friction of its wall along its rim, so slip shows in the forces. If the
wheels together give what gravity asks for and all turn alike, they roll: wheels that slip turn as
fast as their loads let them, and these differ. Wheels that give more push against something; while
they give less the robot slides.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan, sin
from statistics import fmean
from typing import NamedTuple

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.board_spec import WheelSpec
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.sensing.wheel_belief import Believed
from pirate_sm.core._geometry.space import GRAVITY_M_S2

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
    robot: RobotSpec, sensing: Sensing, setpoints: Numbers, by: Believed, pitch_rad: float
) -> WheelGrip:
    """Return whether the wheels may slip, by what they have shown in a round."""
    numbers, weight_n = sensing.numbers, robot.body.weight_n
    driven = [wheel for wheel in robot.wheels if setpoints[wheel.slot]]
    recent_s = sensing.distance.at_s - robot.link.period_s
    heard = [
        wheel
        for wheel in driven
        if not isnan(numbers[wheel.speed])
        and sensing.heard_s[robot.wheel_boards[wheel.place]] > recent_s
    ]
    turning = [
        wheel
        for wheel in heard
        if wheel.place in by.wheels
        and by.odd_s[wheel.place] == sensing.distance.odd_s[wheel.place] == inf
    ]
    if not driven:
        return WheelGrip()
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
    steep = felt and asked_n + drag_n > BALANCED * weight_n
    lacks = excess_n < -slack_n and not isnan(pitch_rad)
    slips = excess_n > slack_n or lacks or (steep and (unalike or len(turning) < _FEW))
    if not slips and not unalike:
        return WheelGrip()
    gripping = _gripping(robot, numbers, turning, setpoints)
    if not gripping and excess_n > slack_n and felt and not steep:
        gripping = _carried(numbers, setpoints, turning)
    if gripping or not slips:
        return WheelGrip(speeds=gripping or ends)
    pull_n = min(asked_n, slack_n - excess_n) if steep and weight_n else 0.0
    vague = len(turning) < _FEW <= len(by.wheels)
    return WheelGrip(True, ends, pull_n / weight_n * GRAVITY_M_S2 if pull_n else 0.0, vague)


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
