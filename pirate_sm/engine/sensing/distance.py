"""Judge odometry: by the wheels that it believes, with a bound of how far the robot may be from it.

A wheel slips only with the friction of its wall along its rim, so slip shows in the forces. If the
wheels together give what gravity asks for and all turn alike, they roll: wheels that slip turn as
fast as their loads let them, and these differ. Wheels that give more push against something; while
they give less the robot slides. What they roll meanwhile is how far odometry may be wrong, and on
a slope the slide comes on top of it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import inf, isnan, nan, sin
from statistics import fmean, median
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.board_spec import WheelSpec
from pirate_sm.engine.sensing.environment import AGREEING
from pirate_sm.engine.sensing.known_signals import DistanceMemory, Numbers, Sensing
from pirate_sm.engine.sensing.wheel_belief import Believed, believed
from pirate_sm.geometry.space import GRAVITY_M_S2

BASE_M = 0.005
"""Reports are late by up to a round of the boards; that makes 4 mm [measured]. Where they are lost
it is more."""

_MISSED = 1.5
"""After so many periods without one a report was lost."""

_ROUND, _UNREAD_S = 0.95, 0.5
"""Wheels are judged once in a round of the boards, which rounding may shorten; where the mission
does not read the distance, after so long a time [decided]."""

_SHARE = 0.006
"""Share of the way by which wheels that roll may be wrong [decided]."""

_LOST = 0.1
"""Where reports are lost, wheels are judged by other moments, and a late brake counts less of what
it has rolled: so much of the way for each share that is lost [decided]."""

_LEANS = 0.25
"""Share of what wheels on the sides of their tyres lack by which that may be wrong; in drawn pipes
it was right within a fifth [measured]."""

_ALIKE = 0.04
"""Wheels turn alike whose speeds differ by less than this share of the largest: one count of the
encoder is 1 % of it in a round [decided]."""

_BALANCED = 0.25
"""Forces are balanced up to this share of the weight; those of wheels that roll up to 0.14
[measured]."""

_EVEN, _NOISE = 0.3, 0.015
"""The wheels of a part share its force evenly up to the first share; that of the outer ones is a
quarter of that of the middle one while they slip. The second is of the top speed or the stall
force, two counts of the encoder [decided]."""

_WITH = 0.1
"""A wheel turns with the others whose speed differs from theirs by up to this share [decided]."""

_SOME = 0.35
"""Share of the differences that counts where some wheels slip and others roll [decided]."""

_FEW = 3
"""So many wheels press differently, so that they do not turn alike while they slip."""

_STARTING_S = 0.35
"""While a robot starts, its boards report different moments of the start; whether it slips then is
decided by what follows [measured: two rounds]."""

_TURNED_RAD = 0.006
"""The noise of two readings of a joint [measured]."""


def counting(robot: RobotSpec, sensing: Sensing, before: DistanceMemory, *, read: bool) -> Sensing:
    """Return the signals of a robot whose odometry begins to count.

    Args:
        robot: A robot with odometry.
        sensing: The signals.
        before: What was remembered when a run was cut off that goes on.
        read: Whether the mission reads the distance, so that each round of the boards is judged.
    """
    every_s = _ROUND * robot.link.period_s if read else _UNREAD_S
    width_m, rolled_m = before.width_m, before.rolled_m
    memory = DistanceMemory(every_s, width_m=width_m, late_m=BASE_M, rolled_m=rolled_m)
    return _with_bound(robot, sensing, sensing.numbers, memory)


def unheard(robot: RobotSpec, sensing: Sensing, now_s: float, away_s: float) -> DistanceMemory:
    """Return what is remembered when the robot is heard again, which may have driven meanwhile.

    Args:
        robot: A robot with odometry.
        sensing: The signals before.
        now_s: When it is; mission time stands still during a silence.
        away_s: How long its controller was silent; NaN if nobody knows.
    """
    memory = sensing.distance
    if memory.running or sensing.asked.driving:
        away_s = inf if isnan(away_s) else max(now_s - max(sensing.heard_s), away_s)
        lost_s = away_s + robot.link.period_s
        top_m_s = max(wheel.top_m_s for wheel in robot.wheels)
        memory = memory._replace(width_m=memory.width_m + top_m_s * lost_s)
    return memory._replace(running=False, out=frozenset())


def _with_bound(
    robot: RobotSpec, sensing: Sensing, numbers: Sequence[float], memory: DistanceMemory
) -> Sensing:
    if robot.bound >= 0:
        numbers = list(numbers)
        numbers[robot.bound] = memory.bound_m if memory.every_s < _UNREAD_S else nan
    return sensing._replace(numbers=tuple(numbers), distance=memory)


def judge(
    robot: RobotSpec,
    sensing: Sensing,
    setpoints: Numbers,
    pitch_rad: float,
    now_s: float,
    held: Collection[int] = (),
    bores_m: Sequence[float] = (),
) -> Sensing:
    """Return the signals after a frame, with odometry judged if that is due.

    Args:
        robot: A robot with odometry.
        sensing: The signals.
        setpoints: In force, per slot.
        pitch_rad: By how much the pipe climbs; NaN is unknown.
        now_s: When it is.
        held: The parts that are clamped.
        bores_m: The inner diameters of the pipe, that of the start first; empty where unknown.
    """
    memory = sensing.distance
    pitch_rad = memory.pitch_rad if isnan(pitch_rad) else pitch_rad
    if not memory.running and sensing.asked.driving:
        return sensing._replace(distance=_begun(robot, sensing, now_s))
    if not memory.running or now_s < memory.due_s:
        return sensing
    rolled_m = [
        (now - then) * wheel.metres_per_rad
        for now, then, wheel in zip(sensing.angles, memory.angles, robot.wheels, strict=True)
    ]
    by = believed(robot, sensing, setpoints, rolled_m, now_s)
    joints = _joints(robot, sensing)
    elapsed_s, grip = now_s - memory.at_s, _grip(robot, sensing, setpoints, by, pitch_rad)
    # Joints are steered and duties trimmed meanwhile: not each array that was sent is a start.
    turns = tuple((setpoints[w.slot] > 0) - (setpoints[w.slot] < 0) for w in robot.wheels)
    begun_s = memory.begun_s if turns == memory.turns else sensing.asked.since_s
    # While it starts and stops, boards report different moments; a robot that slipped still may.
    stops = not sensing.asked.driving and not memory.slipped
    changed_s = max(begun_s, sensing.asked.since_s) if stops else begun_s
    changes = now_s - changed_s < _STARTING_S
    ways_m = [abs(speed * elapsed_s - by.moved_m) for speed in grip.speeds]
    lacking, spanned = _tilted(robot, sensing, held, bores_m)
    slipped_m = 0.0
    if grip.slips:
        slipped_m = max(abs(by.moved_m), *ways_m) + memory.pending_m
        slipped_m += memory.sliding_m_s * elapsed_s + _bent_m(robot, memory.joints, joints)
    elif ways_m and not changes:  # off the axis they differ by as much as the parts lack
        slipped_m = max(0.0, max(ways_m) - lacking * abs(by.moved_m)) * _SOME
    paces_m_s = _paces_m_s(robot, sensing)
    late_m, gone_m = _late_m(robot, sensing, by, paces_m_s, now_s)
    wrong = _SHARE + _LOST * sensing.loss + _LEANS * lacking
    width_m = memory.width_m + wrong * abs(by.moved_m) + _BALANCED * abs(by.missed_m) + gone_m
    sliding_m_s = memory.sliding_m_s + grip.pull_m_s2 * elapsed_s
    pending = grip.slips and (changes or grip.vague)
    running = sensing.asked.driving or any(sensing.shares)
    numbers = list(sensing.numbers)
    numbers[robot.odometry] += by.missed_m - lacking * by.moved_m
    memory = memory._replace(
        running=running,
        begun_s=begun_s,
        turns=turns,
        at_s=now_s,
        due_s=now_s + memory.every_s,
        angles=sensing.angles,
        joints=joints,
        strayed_m=by.strayed_m,
        odd_s=by.odd_s,
        pitch_rad=pitch_rad,
        out=by.out,
        width_m=width_m if pending else width_m + slipped_m,
        paces_m_s=paces_m_s,
        late_m=BASE_M + late_m,
        pending_m=slipped_m if pending else 0.0,
        sliding_m_s=max(0.0, sliding_m_s) if grip.slips else 0.0,
        rolled_m=memory.rolled_m + abs(by.moved_m),
        spanned=spanned,
        slipped=grip.slips and not pending,
    )
    return _with_bound(robot, sensing, numbers, memory)


def _paces_m_s(robot: RobotSpec, sensing: Sensing) -> Numbers:
    """Return per wheel how fast it rolled when that was known last."""
    paces = [sensing.numbers[wheel.speed] * wheel.metres_per_rad for wheel in robot.wheels]
    before = sensing.distance.paces_m_s
    return tuple(old if isnan(now) else now for now, old in zip(paces, before, strict=True))


def _late_m(
    robot: RobotSpec, sensing: Sensing, by: Believed, paces_m_s: Numbers, now_s: float
) -> tuple[float, float]:
    """Return how far the robot may have driven since its wheels should have reported.

    Without its report nobody knows whether a wheel has stopped since, as others may have.

    Returns:
        That of the wheels that count, and of those that have just been silent for too long to.
    """
    period_s, driven = robot.link.period_s, [at for at, each in enumerate(sensing.shares) if each]
    others_m_s = abs(median([paces_m_s[at] for at in driven] or [0.0]))
    late_m = {}
    for at in driven:
        age_s = now_s - sensing.heard_s[robot.wheel_boards[at]]
        late_s = (age_s if age_s > _MISSED * period_s else 0.0) + sensing.loss * period_s
        late_m[at] = max(abs(paces_m_s[at]), others_m_s) * late_s
    counted = [at for at, each in enumerate(sensing.distance.strayed_m) if not isnan(each)]
    gone_m = sum(late_m.get(at, 0.0) for at in counted if isnan(by.strayed_m[at]))
    heard_m = sum(late_m[at] for at in by.wheels)
    return heard_m / max(len(by.wheels), 1), gone_m / max(len(counted), 1)


def _tilted(
    robot: RobotSpec, sensing: Sensing, held: Collection[int], bores_m: Sequence[float]
) -> tuple[float, bool]:
    """Return the share of the way that wheels lack because they run on the sides of their tyres.

    A part in a plane off the axis of a round pipe spans less than its diameter. Its wheels lean
    on the wall, and roll on as much less than their radius as the part spans less. While another
    part lies along the axis, they turn faster than its wheels, which is seen without this.

    Returns:
        The share, and whether a part has spanned the pipe where the run began. Until then less is
        no narrower pipe.
    """
    body, lacks, spanned = robot.body, [], sensing.distance.spanned
    spans = [body.parts[at].diameter for at in held]
    shown = [sensing.numbers[span] for span in spans if span >= 0]
    spanned = spanned or any(each >= bores_m[0] * (1 - AGREEING) for each in shown if bores_m)
    for span_m in shown:
        able = [bore_m for bore_m in bores_m if span_m <= bore_m * (1 + AGREEING)]
        bore_m = min(able, default=0.0) if spanned else bores_m[0] if able else 0.0
        if not span_m < bore_m * (1 - AGREEING):
            return 0.0, spanned  # it lies along the axis, or nobody knows
        lacks.append((bore_m - span_m) / (bore_m - 2 * body.wheel_radius_m))
    return (fmean(lacks) if lacks else 0.0), spanned


def _begun(robot: RobotSpec, sensing: Sensing, now_s: float) -> DistanceMemory:
    """Return what is remembered of a way that begins."""
    count, memory = len(robot.wheels), sensing.distance
    return memory._replace(
        running=True,
        begun_s=now_s,
        at_s=now_s,
        due_s=now_s + memory.every_s,
        angles=sensing.angles,
        joints=_joints(robot, sensing),
        paces_m_s=(0.0,) * count,
        strayed_m=(0.0,) * count,
        odd_s=(inf,) * count,
        sliding_m_s=0.0,
        pending_m=0.0,
    )


def _joints(robot: RobotSpec, sensing: Sensing) -> Numbers:
    return tuple(sensing.numbers[at] for at in robot.body.joints if at >= 0)


def _bent_m(robot: RobotSpec, before: Numbers, now: Numbers) -> float:
    """Return how far wheels may have moved against each other because joints have turned."""
    turned = [abs(new - old) - _TURNED_RAD for new, old in zip(now, before, strict=True)]
    return sum(each for each in turned if each > 0) * max(robot.body.lengths_m)


class Grip(NamedTuple):
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


def _grip(
    robot: RobotSpec, sensing: Sensing, setpoints: Numbers, by: Believed, pitch_rad: float
) -> Grip:
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
        return Grip()
    speeds = [numbers[wheel.speed] * wheel.metres_per_rad for wheel in turning]
    bearing = turning + [w for w in _along(numbers, heard, speeds) if w not in turning]
    drag_n = sum(wheel.drag_n for wheel in driven if wheel not in bearing)
    slack_n = _BALANCED * weight_n + drag_n
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
    steep = felt and asked_n + drag_n > _BALANCED * weight_n
    lacks = excess_n < -slack_n and not isnan(pitch_rad)
    slips = excess_n > slack_n or lacks or (steep and (unalike or len(turning) < _FEW))
    if not slips and not unalike:
        return Grip()
    gripping = _gripping(robot, numbers, turning, setpoints)
    if gripping or not slips:
        return Grip(speeds=gripping or ends)
    pull_n = min(asked_n, slack_n - excess_n) if steep and weight_n else 0.0
    vague = len(turning) < _FEW <= len(by.wheels)
    return Grip(True, ends, pull_n / weight_n * GRAVITY_M_S2 if pull_n else 0.0, vague)


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
