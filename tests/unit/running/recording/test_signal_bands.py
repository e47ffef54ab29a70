"""Bands of curves, held against what is known in closed form.

In a toy signal every order of runs is equally likely, so the chance of a band is a ratio of whole
numbers.
"""

from __future__ import annotations

from math import isnan, nan, sqrt

import numpy as np
import pytest
from pydantic import ValidationError

from pirate_sm.running.recording.signal_bands import (
    CurveName,
    Extremes,
    PhaseBands,
    PhaseExtremes,
    RunExtremes,
    band_of_curves,
    edges_of,
    extremes_of,
    intervals_of,
    signal_bands,
    step_of,
)
from pirate_sm.running.runtime.phase_times import PhaseKey

REPEATED = 2000
CURRENT = CurveName("Currents", "wheel")
DRIVE = PhaseKey("drive", 1)


def run(least: list[float], largest: list[float], step_s: float = 1.0) -> RunExtremes:
    extremes = Extremes(np.array(least), np.array(largest))
    return {DRIVE: PhaseExtremes(len(least) * step_s, step_s, {CURRENT: extremes})}


def bounds(runs: list[RunExtremes]) -> tuple[float, list[tuple[float, float]]]:
    """Return the length of an interval, and the bounds in each."""
    found = signal_bands(runs)
    assert found is not None
    ((_, _, text),) = found.phases[0].curves
    return found.phases[0].step_s, intervals_of(text)


# --- of many runs ---------------------------------------------------------------------------------


@pytest.mark.parametrize("runs", [19, 60])
def test_a_band_holds_the_next_curve_as_often_as_the_order_of_runs_says(runs: int) -> None:
    """The curve is a ramp of a random slope, so in each interval one slope decides both bounds."""
    random = np.random.default_rng(runs)
    rank = (runs + 1) // 20
    exact = (runs + 1 - 2 * rank) / (runs + 1)
    held = np.zeros(3)
    for _ in range(REPEATED):
        slopes = random.exponential(size=runs + 1)[:, None]
        least, largest = slopes * np.arange(3.0), slopes * np.arange(1.0, 4.0)
        least[:, 0] = slopes[:, 0]  # the first is a constant
        band = band_of_curves(map(Extremes, least[:-1], largest[:-1]))
        held += (band.least <= least[-1]) & (largest[-1] <= band.largest)

    assert exact >= 0.9
    assert held / REPEATED == pytest.approx(exact, abs=4 * sqrt(0.09 / REPEATED))


def test_a_curve_that_swings_freely_is_held_at_least_as_often() -> None:
    """Least and largest value are independent here, and either may be outside."""
    random = np.random.default_rng(5)
    held = 0
    for _ in range(REPEATED):
        least, largest = random.uniform(-2, -1, (60, 1)), random.uniform(1, 2, (60, 1))
        band = band_of_curves(map(Extremes, least[:-1], largest[:-1]))
        held += bool(band.least <= least[-1] and largest[-1] <= band.largest)

    assert held / REPEATED == pytest.approx((57 / 60) ** 2, abs=4 * sqrt(0.09 / REPEATED))


def test_only_runs_that_were_in_the_phase_for_as_long_count() -> None:
    """Slow runs draw more current all along: fast ones would make later seconds look low."""
    fast, slow = run([1.0], [1.0]), run([5.0, 5.0], [6.0, 6.0])

    assert bounds([fast] * 30 + [slow] * 19) == (1.0, [(1.0, 6.0), (5.0, 6.0)])
    assert bounds([fast] * 30 + [slow] * 18) == (1.0, [(1.0, 6.0)])


def test_a_run_of_which_nothing_is_known_does_not_count() -> None:
    _, (first, second) = bounds(
        [run([nan, 2.0], [nan, 3.0])] * 5 + [run([1.0] * 2, [1.0] * 2)] * 18
    )

    assert all(map(isnan, first))
    assert second == (1.0, 3.0)


def test_runs_with_intervals_of_different_lengths_are_compared_in_the_longest() -> None:
    short, long = run([1.0, 0.0, 7.0], [2.0, 3.0, 8.0]), run([4.0, 4.0], [5.0, 5.0], 2.0)

    assert bounds([short] * 10 + [long] * 10) == (2.0, [(0.0, 5.0), (4.0, 8.0)])


def test_there_is_no_band_of_too_few_runs_or_of_a_phase_that_takes_no_time() -> None:
    assert signal_bands([run([1.0] * 8, [2.0] * 8)] * 18) is None
    assert signal_bands([run([1.0] * 3, [2.0] * 3, 0.25)] * 40) is None
    assert signal_bands([]) is None


def test_the_size_of_the_bands_is_limited_by_longer_intervals() -> None:
    random = np.random.default_rng(1)
    curves = {
        CurveName("Currents", f"wheel_{number}"): Extremes(*random.uniform(size=(2, 40)))
        for number in range(200)
    }
    phases = {PhaseKey("drive", nth): PhaseExtremes(10.0, 0.25, curves) for nth in range(1, 6)}
    found = signal_bands([phases] * 19)

    assert found is not None
    assert 100_000 < len(found.model_dump_json()) < 600_000
    assert {each.step_s for each in found.phases} == {1.0}


# --- of one run -----------------------------------------------------------------------------------


def test_a_phase_has_up_to_forty_intervals_that_double_with_its_length() -> None:
    assert [step_of(each) for each in (0.1, 10.0, 10.1, 60.0)] == [0.25, 0.25, 0.5, 2.0]
    assert edges_of(1.0, 1.6, 0.25).tolist() == pytest.approx([1.0, 1.25, 1.5, 1.6])
    assert edges_of(0.3, 0.8, 0.25).tolist() == pytest.approx([0.3, 0.55, 0.8])
    assert len(edges_of(0.0, 1e-9, 0.25)) == 2


@pytest.mark.parametrize(
    ("stepped", "least", "largest"),
    [
        (False, [0.0, 2.66, 1.0, 1.0], [2.67, 4.0, 3.0, 1.0]),
        (True, [0.0, 0.0, 4.0, 1.0], [0.0, 4.0, 4.0, 1.0]),
    ],
)
def test_extremes_are_those_of_the_whole_curve_between_edges(
    stepped: bool, least: list[float], largest: list[float]
) -> None:
    """Its peak is between two edges, and one of its intervals has no point."""
    times_s, values = np.array([0.0, 1.5, 3.0]), np.array([0.0, 4.0, 1.0])
    found = extremes_of(times_s, values, np.arange(5.0), 2, stepped=stepped)

    assert found.least.tolist() == pytest.approx(least)
    assert found.largest.tolist() == pytest.approx(largest)


def test_nothing_is_known_before_the_first_point_and_in_a_gap() -> None:
    times_s, values = np.array([1.5, 2.0, 2.5, 4.5]), np.array([1.0, 2.0, nan, 5.0])
    found = extremes_of(times_s, values, np.arange(7.0), 0, stepped=False)

    assert np.isnan(found.least).tolist() == [True, False, False, True, False, False]
    assert found.largest[1:3].tolist() == [2.0, 2.0]
    assert found.least[4:].tolist() == [5.0, 5.0]
    empty = extremes_of(np.array([]), np.array([]), np.arange(3.0), 0, stepped=False)
    assert np.isnan(empty.largest).all()


# --- as text --------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["1..2*9", "-1.5..2e-05 -*3 0..0", "1..1"])
def test_bands_can_be_written_and_read(text: str) -> None:
    it = PhaseBands(phase="drive", time=1, step_s=0.5, curves=(("Currents", "wheel", text),))

    assert it.key == DRIVE
    assert len(intervals_of(text)) in (9, 5, 1)


@pytest.mark.parametrize("text", ["", "1", "1..", "a..b", "1..2*100", "1..2  3..4", "nan..nan"])
def test_what_is_no_band_is_refused(text: str) -> None:
    with pytest.raises(ValidationError, match="pattern"):
        PhaseBands(phase="drive", time=1, step_s=0.5, curves=(("Currents", "wheel", text),))
