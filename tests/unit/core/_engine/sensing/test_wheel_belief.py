"""Which wheels odometry believes, round by round."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from math import inf, isnan, nan

import pytest
from driving import PIRATE

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.known_signals import DistanceMemory, Sensing, nothing_known
from pirate_sm.core._engine.sensing.wheels import Believed, believed
from pirate_sm.core._loading.robot.loader import load_robot

ROUND_S, NOW_S = 0.1, 50.0
EVERY = frozenset(range(6))
STILL = {0: 0.0}
"""The first wheel stands while the others roll."""


@cache
def robot() -> RobotSpec:
    return load_robot(PIRATE).normal


def setpoints(duty: float = 1.0) -> tuple[float, ...]:
    """All wheels are driven forward."""
    values = [0.0] * len(robot().slots)
    for wheel in robot().wheels:
        values[wheel.slot] = duty if wheel.metres_per_rad > 0 else -duty
    return tuple(values)


def seen(
    rolled_m: Mapping[int, float],
    memory: DistanceMemory,
    heard_s: Mapping[int, float] | None = None,
    force: Mapping[int, float] | None = None,
) -> Sensing:
    """What is known at the end of a round; forces are shares of that of the stalled motor."""
    fresh = nothing_known(robot())
    numbers, heard = list(fresh.numbers), [NOW_S] * len(fresh.heard_s)
    for wheel, board in zip(robot().wheels, robot().wheel_boards, strict=True):
        numbers[wheel.speed] = rolled_m[wheel.place] / ROUND_S / wheel.metres_per_rad
        newtons = (force or {}).get(wheel.place, 0.05) * wheel.stall_n
        numbers[wheel.load] = newtons / wheel.n_per_a
        heard[board] = (heard_s or {}).get(wheel.place, NOW_S)
    return fresh._replace(
        numbers=tuple(numbers), heard_s=tuple(heard), shares=(1 / 6,) * 6, distance=memory
    )


def after(
    strayed_m: Mapping[int, float] | None = None,
    odd_s: Mapping[int, float] | None = None,
    out: frozenset[int] = frozenset(),
) -> DistanceMemory:
    """What is remembered of the round before."""
    return DistanceMemory(
        at_s=NOW_S - ROUND_S,
        running=True,
        strayed_m=tuple((strayed_m or {}).get(at, 0.0) for at in range(6)),
        odd_s=tuple((odd_s or {}).get(at, inf) for at in range(6)),
        out=out,
    )


def round_of(
    rolled_m: Mapping[int, float],
    memory: DistanceMemory | None = None,
    heard_s: Mapping[int, float] | None = None,
    force: Mapping[int, float] | None = None,
    others_m: float = 0.01,
    duty: float = 1.0,
) -> Believed:
    """What is believed after a round in which the others have rolled so far."""
    ways_m = {at: rolled_m.get(at, others_m) for at in range(6)}
    known_m = {at: 0.0 if isnan(way_m) else way_m for at, way_m in ways_m.items()}
    sensing = seen(known_m, memory or after(), heard_s, force)
    return believed(robot(), sensing, setpoints(duty), [ways_m[at] for at in range(6)], NOW_S)


def test_wheels_that_roll_together_all_count() -> None:
    found = round_of({})

    assert found.wheels == tuple(range(6))
    assert found.moved_m == pytest.approx(0.01)
    assert found.missed_m == 0.0
    assert found.strayed_m == pytest.approx((0.0,) * 6)
    assert found.odd_s == (inf,) * 6
    assert found.out == frozenset()


def test_a_wheel_that_is_limp_for_a_moment_still_counts() -> None:
    found = round_of(STILL)

    assert found.wheels == tuple(range(6))
    assert found.odd_s == (NOW_S, *(inf,) * 5)
    assert found.moved_m == pytest.approx(0.05 / 6)
    assert found.strayed_m == pytest.approx((-0.05 / 6, *(0.01 / 6,) * 5))


@pytest.mark.parametrize(("since_s", "out"), [(0.29, frozenset()), (0.31, frozenset({0}))])
def test_belief_in_a_wheel_that_is_limp_ends_with_all_that_it_has_shown(
    since_s: float, out: frozenset[int]
) -> None:
    lacking_m = {0: -0.02, **dict.fromkeys(range(1, 6), 0.004)}
    found = round_of(STILL, after(lacking_m, {0: NOW_S - since_s}))

    assert found.out == out
    assert found.wheels == tuple(sorted(EVERY - out))
    kept = 1 - ROUND_S / 2.0
    missed_m = 0.004 * kept + 0.01 / 6 if out else 0.0
    assert found.missed_m == pytest.approx(missed_m)
    assert found.moved_m == pytest.approx(0.05 / 6 + missed_m)
    assert found.odd_s[0] == (inf if out else NOW_S - since_s)
    assert found.strayed_m[1:] == pytest.approx((0.004 * kept + 0.01 / 6 - missed_m,) * 5)


def test_a_wheel_that_stands_and_bears_force_is_not_limp() -> None:
    assert round_of(STILL, force={0: 0.6}).odd_s == (inf,) * 6
    assert round_of(STILL, force={0: 0.4}).odd_s[0] == NOW_S


@pytest.mark.parametrize(
    ("duty", "speed", "force", "limp"),
    [
        *((1.0, 0.045, 0.0, True), (1.0, 0.055, 0.0, False)),
        *((0.5, 0.0225, 0.0, True), (0.5, 0.0275, 0.0, False)),
        *((0.5, 0.0, 0.24, True), (0.5, 0.0, 0.26, False)),
    ],
)
def test_a_wheel_is_limp_by_its_speed_and_force_for_its_duty(
    duty: float, speed: float, force: float, limp: bool
) -> None:
    rolled_m = speed * robot().wheels[0].top_m_s * ROUND_S

    found = round_of({0: rolled_m}, force={0: force}, duty=duty)

    assert found.odd_s == (NOW_S if limp else inf, *(inf,) * 5)


def test_of_three_wheels_one_may_stray() -> None:
    unknown = dict.fromkeys(range(3, 6), nan)
    found = round_of(unknown, after({0: 0.05} | unknown))

    assert found.out == {0}
    assert found.wheels == (1, 2)


def test_a_wheel_that_does_not_share_the_way_is_not_counted() -> None:
    sensing = seen(dict.fromkeys(range(6), 0.01), after())
    sensing = sensing._replace(shares=(0.0, *(0.2,) * 5))

    found = believed(robot(), sensing, setpoints(), [0.01] * 6, NOW_S)

    assert found.wheels == (1, 2, 3, 4, 5)
    assert isnan(found.strayed_m[0])


def test_without_a_wheel_that_counts_nothing_has_moved() -> None:
    found = round_of({}, after(dict.fromkeys(range(6), nan)))

    assert (found.wheels, found.moved_m, found.missed_m) == ((), 0.0, 0.0)
    assert found.strayed_m == (0.0,) * 6


def test_a_wheel_that_turns_again_is_limp_no_longer() -> None:
    assert round_of({}, after(odd_s={0: NOW_S - 0.2})).odd_s == (inf,) * 6


def test_where_all_wheels_are_limp_none_is_left_out() -> None:
    memory = after(odd_s=dict.fromkeys(range(6), NOW_S - 1.0))
    found = round_of({}, memory, others_m=0.0)

    assert found.out == frozenset()
    assert found.wheels == tuple(range(6))


@pytest.mark.parametrize(("ahead_m", "out"), [(0.024, frozenset()), (0.0245, frozenset({0}))])
@pytest.mark.parametrize("way", [1, -1])
def test_belief_in_a_wheel_ends_where_it_strays_from_the_others(
    ahead_m: float, out: frozenset[int], way: int
) -> None:
    memory = after({0: way * (ahead_m - 0.004) / 0.95}, None)
    found = round_of({0: 0.01 + way * 0.0048}, memory)

    assert found.out == out
    assert found.moved_m == pytest.approx(0.01 if out else 0.01 + way * 0.0048 / 6, abs=1e-4)


def test_a_report_that_is_lost_is_no_straying() -> None:
    memory = after({0: -0.02})

    assert round_of(STILL, memory, heard_s={0: memory.at_s - 0.05}, force={0: 1.0}).out == set()
    assert round_of(STILL, memory, heard_s={0: memory.at_s}, force={0: 1.0}).out == set()
    assert round_of(STILL, memory, force={0: 1.0}).out == {0}
    old_s = NOW_S - robot().link.silent_after_s * 0.6
    assert round_of(STILL, after({0: -0.06}), heard_s={0: old_s}, force={0: 1.0}).out == {0}


@pytest.mark.parametrize("way", [1, -1])
def test_belief_in_a_wheel_lasts_where_the_reports_of_the_others_are_lost(way: int) -> None:
    """Two wheels have just reported what they rolled, and the others not for some rounds."""
    unheard = dict.fromkeys(range(2, 6), NOW_S - 0.25)
    strayed_m = dict.fromkeys(range(2), way * 0.018) | dict.fromkeys(range(2, 6), way * -0.009)
    rolled_m = dict.fromkeys(range(2), way * 0.01) | dict.fromkeys(range(2, 6), 0.0)

    def found(heard_s: Mapping[int, float]) -> Believed:
        sensing = seen(dict.fromkeys(range(6), way * 0.01), after(strayed_m), heard_s)
        return believed(robot(), sensing, setpoints(), [rolled_m[at] for at in range(6)], NOW_S)

    assert found({}).out == {0, 1}, "they spin"
    assert found(unheard).out == frozenset()
    assert found(unheard).missed_m == 0.0


def test_what_has_strayed_is_forgotten_with_time() -> None:
    memory = after({0: 0.02, 1: -0.02})

    assert round_of({}, memory).strayed_m[:2] == pytest.approx((0.019, -0.019))
    long_ago = memory._replace(at_s=NOW_S - 3.0)
    assert round_of({}, long_ago).strayed_m[:2] == pytest.approx((0.0, 0.0))


def test_of_two_wheels_none_strays() -> None:
    unknown = dict.fromkeys(range(2, 6), nan)
    found = round_of({0: 0.05} | unknown, after({0: 0.05} | unknown))

    assert found.out == frozenset()
    assert found.wheels == (0, 1)


def test_a_wheel_that_is_silent_does_not_count_and_begins_again_with_its_next_report() -> None:
    silent_s = {0: NOW_S - robot().link.silent_after_s - 0.01}
    found = round_of(STILL, heard_s=silent_s)
    assert isnan(found.strayed_m[0])
    assert found.wheels == (1, 2, 3, 4, 5)
    assert found.moved_m == pytest.approx(0.01)

    back = round_of({0: 0.3}, after({0: nan}))
    assert back.strayed_m[0] == 0.0
    assert back.wheels == (1, 2, 3, 4, 5)
    assert back.moved_m == pytest.approx(0.01)


def test_a_way_that_is_not_known_does_not_count() -> None:
    found = round_of({0: nan})

    assert found.wheels == (1, 2, 3, 4, 5)
    assert isnan(found.strayed_m[0])


@pytest.mark.parametrize(
    ("rolled_m", "others_m", "along"),
    [
        *((0.0128, 0.01, True), (0.0132, 0.01, False), (0.0072, 0.01, True), (0.0068, 0.01, False)),
        *((-0.0128, -0.01, True), (0.0015, 0.0015, False), (0.0025, 0.0025, True)),
    ],
)
def test_a_wheel_turns_with_the_others_by_what_both_have_rolled(
    rolled_m: float, others_m: float, along: bool
) -> None:
    memory = after({0: nan}, out=frozenset({0}))

    found = round_of({0: rolled_m}, memory, others_m=others_m)

    assert found.out == {0}
    assert found.odd_s[0] == (NOW_S if along else inf)


@pytest.mark.parametrize(("since_s", "out"), [(0.95, frozenset({0})), (1.0, frozenset())])
def test_belief_in_a_wheel_returns_when_it_has_turned_with_the_others_for_a_second(
    since_s: float, out: frozenset[int]
) -> None:
    memory = after({0: nan}, {0: NOW_S - since_s}, frozenset({0}))

    found = round_of({}, memory)

    assert found.out == out
    assert found.odd_s[0] == (NOW_S - since_s if out else inf)
