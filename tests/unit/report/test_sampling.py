from __future__ import annotations

from math import isnan, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.report.model import Series
from pirate_sm.report.sampling import Samples, thinned, value_at

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


@given(st.lists(st.tuples(NUMBERS, NUMBERS), max_size=30))
def test_what_is_told_is_noted_and_so_is_what_changes_untold(rows: list[tuple[float, float]]):
    samples = Samples(2)
    for number, row in enumerate(rows):
        samples.take(float(number), row, told=(0,))

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
