"""Which wheels odometry believes.

A driven wheel that neither turns nor bears the force of its motor is dead, or its sensor is. One
that strays from the others spins, sticks or is silent. What such a wheel has shown since it began
is taken out of the odometry again. It is believed again once it has turned with the others.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from math import inf, isnan, nan
from statistics import fmean, median
from typing import NamedTuple

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.board_spec import WheelSpec
from pirate_sm.core._engine.sensing.known_signals import Sensing

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
    late_m = late(robot, sensing, strayed_m, now_s, robot.link.silent_after_s / 4)
    least = {at: each + min(0.0, late_m[at]) for at, each in strayed_m.items()}
    most = {at: each + max(0.0, late_m[at]) for at, each in strayed_m.items()}
    low_m, high_m = median(least.values()) - _STRAYED_M, median(most.values()) + _STRAYED_M
    return {at for at in strayed_m if most[at] < low_m or least[at] > high_m}


def late(
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
