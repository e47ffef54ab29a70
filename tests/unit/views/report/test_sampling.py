from __future__ import annotations

from math import isnan, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.views.report import charts
from pirate_sm.views.report.charts import Curve, Samples, thinned, value_at
from pirate_sm.views.report.contents import Series

NUMBERS = st.floats(-1e6, 1e6) | st.just(nan)


@given(st.lists(NUMBERS, min_size=40, max_size=400), st.integers(6, 30))
def test_a_thinned_curve_keeps_its_extremes_its_ends_and_its_gaps(values: list[float], most: int):
    times = [0.1 * number for number in range(len(values))]

    thin_times, thin_values = thinned(times, values, most)

    assert len(thin_values) <= most + 2
    assert sorted(thin_times) == thin_times
    assert (thin_times[0], thin_times[-1]) == (times[0], times[-1])
    known = [value for value in values if not isnan(value)]
    if known:
        kept = [value for value in thin_values if not isnan(value)]
        assert (min(kept), max(kept)) == (min(known), max(known))
    assert any(map(isnan, thin_values)) == any(map(isnan, values))


def test_what_a_thinned_curve_holds_at_last_is_what_held_then():
    times = [float(number) for number in range(400)]
    values = [0.0, 9.0, 5.0, *([5.0] * 397)]

    thin_times, thin_values = thinned(times, values, 40)

    after = [value for at_s, value in zip(thin_times, thin_values, strict=True) if at_s > 10]
    assert set(after) == {5.0}


@given(st.lists(NUMBERS, min_size=1, max_size=600), st.floats(0.001, 50.0))
def test_a_curve_of_any_length_looks_the_same_and_takes_no_more_room(
    values: list[float], apart_s: float
):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(charts, "_MOST_KEPT", 64)
        curve, most = Curve(), 0
        for number, value in enumerate(values):
            curve.add(np.array([number * apart_s]), np.array([value]))
            most = max(most, len(curve._times))
        times, kept = curve.points()

    assert most <= 65
    assert len(kept) == len(times) <= len(values)
    assert sorted(times) == times
    assert (times[0], times[-1]) == (0.0, (len(values) - 1) * apart_s)
    assert repr((kept[0], kept[-1])) == repr((values[0], values[-1]))
    known = [value for value in values if not isnan(value)]
    if known:
        seen = [value for value in kept if not isnan(value)]
        assert (min(seen), max(seen)) == (min(known), max(known))
    assert any(map(isnan, kept)) == any(map(isnan, values))


def test_a_long_curve_is_as_fine_all_along():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(charts, "_MOST_KEPT", 400)
        curve = Curve()
        numbers = np.arange(20_000)
        curve.add(0.5 * numbers, numbers % 7.0)
        times, _ = curve.points()

    in_each = [sum(low <= at_s < low + 1_000 for at_s in times) for low in range(0, 10_000, 1_000)]
    assert min(in_each) > max(in_each) * 0.7
    assert max(in_each) < 40


@given(st.lists(st.tuples(NUMBERS, NUMBERS), max_size=30))
def test_what_is_told_is_noted_and_so_is_what_changes_untold(rows: list[tuple[float, float]]):
    samples = Samples(2)
    for number, row in enumerate(rows):
        samples.take(float(number), row, measured=(0,))

    told, other = samples.series(0, "told"), samples.series(1, "other")

    # `repr` makes an unknown value equal to itself.
    assert list(map(repr, told.values)) == [repr(first) for first, _ in rows]
    assert all(repr(a) != repr(b) for a, b in zip(other.values, other.values[1:], strict=False))
    for number, (_, second) in enumerate(rows):
        seen = [v for t, v in zip(other.times_s, other.values, strict=True) if t <= number]
        assert repr(seen[-1] if seen else nan) == repr(second)


@pytest.mark.parametrize(
    ("at_s", "straight", "stepped"),
    [
        (-1, nan, nan),
        (0, 1, 1),
        (0.5, 2, 1),
        (1, 3, 3),
        (1.5, 3, 3),
        (2.5, nan, nan),
        (3.5, 8, 8),
        (9, 8, 8),
    ],
)
def test_between_two_points_a_curve_is_straight_or_holds(at_s, straight, stepped):
    times, values = (0.0, 1.0, 2.0, 3.0), (1.0, 3.0, nan, 8.0)

    found = value_at(Series("", times, values), at_s)
    held = value_at(Series("", times, values, stepped=True), at_s)

    assert found == pytest.approx(straight, nan_ok=True)
    assert held == pytest.approx(stepped, nan_ok=True)


def test_a_setpoint_holds_until_the_end():
    samples = Samples(1)
    samples.take(1.0, (0.25,))

    series = samples.series(0, "", scale=100, until_s=4.0)

    assert (series.times_s, series.values) == ([1.0, 4.0], [25.0, 25.0])
