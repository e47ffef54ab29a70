"""Judge odometry: by the wheels that it believes, with a bound of how far the robot may be from it.

What wheels roll while they may slip (see :mod:`.wheels`) is how far odometry may be wrong. On
a slope the slide comes on top of it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import copysign, inf, isinf, isnan, nan
from statistics import fmean, median

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.known_signals import DistanceMemory, Sensing
from pirate_sm.core._engine.sensing.surveyor import AGREEING
from pirate_sm.core._engine.sensing.wheels import BALANCED, Believed, believed, judge_grip

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

_LEANS, _LEANS_AT_MOST = 0.25, 0.02
"""Share of what wheels on the sides of their tyres lack by which that may be wrong, and the share
of the way that this is at most: in drawn pipes it was right within 2 % of the way, however much
they lacked [measured]."""

_DRAGS, _DRAGS_AT_MOST = 4.0, 0.08
"""The same while they drag dead wheels: under this load they creep, by up to 7 % of the way in
drawn pipes [measured]."""

_SOME = 0.35
"""Share of the differences that counts where some wheels slip and others roll [decided]."""

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
    width_m, rolled_m = before.width_m + abs(before.apart_m), before.rolled_m
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
    elapsed_s = now_s - memory.at_s
    grip = judge_grip(robot, sensing, setpoints, by, pitch_rad, held)
    turns, begun_s, changed_s = _changed(robot, sensing, setpoints)
    changes = now_s - changed_s < _STARTING_S
    ways_m = [abs(speed * elapsed_s - by.moved_m) for speed in grip.speeds]
    lacking, spanned = _tilted(robot, sensing, held, bores_m)
    slipped_m, apart_m = 0.0, memory.apart_m
    if grip.slips:
        slipped_m = max(abs(by.moved_m), *ways_m) + memory.pending_m
        slipped_m += memory.sliding_m_s * elapsed_s + _bent_m(robot, memory.joints, joints)
    else:
        if ways_m and not changes:  # off the axis they differ by as much as the parts lack
            slipped_m = max(0.0, max(ways_m) - lacking * abs(by.moved_m)) * _SOME
        apart_m += _apart_m(by, rolled_m)
        apart_m = copysign(max(0.0, abs(apart_m) - slipped_m), apart_m)
    paces_m_s = _paces_m_s(robot, sensing)
    late_m, gone_m = _late_m(robot, sensing, by, setpoints, paces_m_s, now_s)
    leans, at_most = (_DRAGS, _DRAGS_AT_MOST) if by.out else (_LEANS, _LEANS_AT_MOST)
    wrong = _SHARE + _LOST * sensing.loss + min(leans * lacking, at_most)
    width_m = memory.width_m + wrong * abs(by.moved_m) + BALANCED * abs(by.missed_m) + gone_m
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
        apart_m=apart_m,
        late_m=BASE_M + late_m + abs(apart_m),
        pending_m=slipped_m if pending else 0.0,
        sliding_m_s=max(0.0, sliding_m_s) if grip.slips else 0.0,
        rolled_m=memory.rolled_m + abs(by.moved_m),
        spanned=spanned,
        slipped=grip.slips and not pending,
    )
    return _with_bound(robot, sensing._replace(shares=_shares(sensing, by)), numbers, memory)


def _changed(
    robot: RobotSpec, sensing: Sensing, setpoints: Numbers
) -> tuple[tuple[int, ...], float, float]:
    """Return in which directions wheels are driven, since when, and when that began or ended."""
    memory = sensing.distance
    # Joints are steered and duties trimmed meanwhile: not each array that was sent is a start.
    turns = tuple((setpoints[w.slot] > 0) - (setpoints[w.slot] < 0) for w in robot.wheels)
    begun_s = memory.begun_s if turns == memory.turns else sensing.asked.since_s
    # While it starts and stops, boards report different moments; a robot that slipped still may.
    stops = not sensing.asked.driving and not memory.slipped
    return turns, begun_s, max(begun_s, sensing.asked.since_s) if stops else begun_s


def _shares(sensing: Sensing, by: Believed) -> Numbers:
    """Return the shares of the wheels, which differ from now on if others are believed."""
    before = sensing.distance.out
    if by.out == before:
        return sensing.shares
    if not sensing.asked.driving:  # of a stop only what was rolled before it counts
        return tuple(0.0 if at in by.out else share for at, share in enumerate(sensing.shares))
    count = {*by.wheels, *(before - by.out)}
    return tuple(1 / len(count) if at in count else 0.0 for at in range(len(sensing.shares)))


def _apart_m(by: Believed, rolled_m: Sequence[float]) -> float:
    """Return what most of the wheels that turn have rolled in a round less the mean of these.

    A few slip or are held back, at forces at which the others roll.
    """
    turning_m = [rolled_m[at] for at in by.wheels if isinf(by.odd_s[at])]
    return median(turning_m) - fmean(turning_m) if turning_m else 0.0


def _paces_m_s(robot: RobotSpec, sensing: Sensing) -> Numbers:
    """Return per wheel how fast it rolled when that was known last."""
    paces = [sensing.numbers[wheel.speed] * wheel.metres_per_rad for wheel in robot.wheels]
    before = sensing.distance.paces_m_s
    return tuple(old if isnan(now) else now for now, old in zip(paces, before, strict=True))


def _late_m(
    robot: RobotSpec,
    sensing: Sensing,
    by: Believed,
    setpoints: Numbers,
    paces_m_s: Numbers,
    now_s: float,
) -> tuple[float, float]:
    """Return how far the robot may have driven since its wheels should have reported.

    Without its report nobody knows whether a wheel has stopped since, as others may have. One that
    is limp is dead, or its board has repeated its report while it has rolled as it is driven.

    Returns:
        That of the wheels that count, and of those that have just been silent for too long to.
    """
    period_s, driven = robot.link.period_s, [at for at, each in enumerate(sensing.shares) if each]
    others_m_s = abs(median([paces_m_s[at] for at in driven] or [0.0]))
    late_m = {}
    for at in driven:
        age_s = now_s - sensing.heard_s[robot.wheel_boards[at]]
        late_s = (age_s if age_s > _MISSED * period_s else 0.0) + sensing.loss * period_s
        pace_m_s = max(abs(paces_m_s[at]), others_m_s)
        if not isinf(by.odd_s[at]):
            late_s = max(late_s, now_s - by.odd_s[at] + period_s)
            pace_m_s = abs(setpoints[robot.wheels[at].slot]) * robot.wheels[at].top_m_s
        late_m[at] = pace_m_s * late_s
    counted = [at for at, each in enumerate(sensing.distance.strayed_m) if not isnan(each)]
    gone_m = sum(late_m.get(at, 0.0) for at in counted if isnan(by.strayed_m[at]))
    heard_m = sum(late_m[at] for at in by.wheels)
    return heard_m / max(len(by.wheels), 1), gone_m / max(len(counted), 1)


def _tilted(
    robot: RobotSpec, sensing: Sensing, held: Collection[int], bores_m: Sequence[float]
) -> tuple[float, bool]:
    """Return the share of the way that wheels lack because they run on the sides of their tyres.

    A part in a plane off the axis of a round pipe spans less than its diameter. Its wheels lean
    on the wall, and roll on as much less than their radius as the part spans less, but on no
    smaller circle than the edge of a tyre. While another
    part lies along the axis, they turn faster than its wheels, which is seen without this. One that
    nearly does lacks what it spans less, and the other one no less.

    Returns:
        The share, and whether a part has spanned the pipe where the run began. Until then less is
        no narrower pipe.
    """
    body, lacks, leans = robot.body, [], True
    spans = [body.parts[at].diameter for at in held]
    shown = [sensing.numbers[span] for span in spans if span >= 0]
    spanned = sensing.distance.spanned
    spanned = spanned or any(each >= bores_m[0] * (1 - AGREEING) for each in shown if bores_m)
    for span_m in shown:
        able = [bore_m for bore_m in bores_m if span_m <= bore_m * (1 + AGREEING)]
        bore_m = min(able, default=0.0) if spanned else bores_m[0] if able else 0.0
        leans &= span_m < bore_m * (1 - AGREEING)
        lack_m = bore_m - span_m if span_m < bore_m else 0.0  # or nobody knows
        lack = lack_m / (bore_m - 2 * body.wheel_radius_m) if lack_m else 0.0
        lacks.append(min(lack, body.edge_lacks))
    share = fmean if leans else min
    return (share(lacks) if lacks else 0.0), spanned


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
