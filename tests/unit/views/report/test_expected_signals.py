"""Bands of earlier runs behind the plots of a report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isnan
from pathlib import Path

import numpy as np
import pytest

from pirate_sm.running.recording.forecast_file import ForecastFile, counted, forecast_of
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.signal_bands import Extremes, signal_bands
from pirate_sm.views.report.contents import Report, Series
from pirate_sm.views.report.expectations import with_expectations
from pirate_sm.views.report.expected_signals import run_extremes
from pirate_sm.views.report.report_page import report_json

RUNS = 40


@pytest.fixture(scope="session")
def earlier(
    recording: Callable[[str], Path], report: Callable[[str], Report]
) -> Callable[[str], ForecastFile]:
    """Gives the forecast from many runs that were just like one of those that are recorded."""

    def get(name: str) -> ForecastFile:
        found = counted(read_recording(recording(name)))
        it = forecast_of(found.header, [found.visits] * RUNS)
        return it.model_copy(update={"signals": signal_bands([run_extremes(report(name))] * RUNS)})

    return get


def curves(report: Report) -> dict[tuple[str, str], Series]:
    return {(chart.title, each.name): each for chart in report.charts for each in chart.series}


def share_outside(series: Series, digits: int = 4) -> float:
    """The share of the points of a curve with a band that are outside of it."""
    assert series.band is not None
    times_s, low, high = map(np.array, series.band)
    at = np.searchsorted(times_s, series.times_s, "right") - 1
    known = at >= 0
    values, at = np.array(series.values)[known], at[known]
    bounded = ~np.isnan(low[at]) & ~np.isnan(values)
    off = 0.5 * 10.0**-digits
    outside = (values < low[at] - off) | (values > high[at] + off)
    return float(np.mean(outside[bounded])) if bounded.any() else 0.0


def test_a_run_like_all_earlier_ones_is_inside_its_bands(
    report: Callable[[str], Report], earlier: Callable[[str], ForecastFile]
) -> None:
    found = curves(with_expectations(report("patrol"), earlier("patrol")))
    banded = [each for each in found.values() if each.band is not None]

    assert len(banded) > 10
    for each in banded:
        # A value may step a moment after the phase that it belongs to has begun.
        assert share_outside(each) < 0.01 or each.stepped
    json = report_json(with_expectations(report("patrol"), earlier("patrol")))
    chart = next(each for each in json["charts"] if "bands" in each)
    assert chart["bands"] == "shaded: 90 % of 40 runs on sim, each moment by itself"
    band = next(each["band"] for each in chart["series"] if "band" in each)
    clock = json["clocks"][band["clock"]]
    assert len(clock) == len(band["low"]) == len(band["high"])


def test_a_curve_that_runs_elsewhere_is_outside_its_band(
    report: Callable[[str], Report], earlier: Callable[[str], ForecastFile]
) -> None:
    usual, chart = report("patrol"), report("patrol").charts[0]
    moved = [
        replace(each, values=[value + 1000.0 for value in each.values]) for each in chart.series
    ]
    other = replace(usual, charts=(replace(chart, series=tuple(moved)),))
    found = curves(with_expectations(other, earlier("patrol")))

    assert {share_outside(each) for each in found.values() if each.band is not None} == {1.0}


def test_a_curve_or_a_phase_without_a_band_draws_nothing(
    report: Callable[[str], Report], earlier: Callable[[str], ForecastFile]
) -> None:
    it, forecast = report("patrol"), earlier("patrol")
    assert forecast.signals is not None
    chart = it.charts[0]
    unknown = replace(chart, title="Temperatures")
    assert with_expectations(replace(it, charts=(unknown,)), forecast).charts == (unknown,)
    assert with_expectations(replace(it, passages=()), forecast).charts == it.charts

    (first, *_) = forecast.signals.phases
    only_first = forecast.signals.model_copy(update={"phases": (first,)})
    found = with_expectations(it, forecast.model_copy(update={"signals": only_first}))
    passage = next(each for each in it.passages if each.key == first.key)
    band = next(each.band for each in found.charts[0].series if each.band is not None)
    assert (band.times_s[0], band.times_s[-1]) == (passage.since_s, passage.until_s)
    assert isnan(band.low[-1])


def test_a_band_ends_where_too_few_runs_were_in_the_phase_for_as_long(
    report: Callable[[str], Report], earlier: Callable[[str], ForecastFile]
) -> None:
    it, forecast = report("patrol"), earlier("patrol")
    assert forecast.signals is not None
    key = forecast.signals.phases[0].key
    passage = next(each for each in it.passages if each.key == key)
    longer = passage._replace(until_s=passage.until_s + 1000.0)
    found = with_expectations(replace(it, passages=(longer,)), forecast)
    band = next(each.band for each in found.charts[0].series if each.band is not None)
    known_s = [at_s for at_s, low in zip(band.times_s, band.low, strict=True) if not isnan(low)]

    assert passage.since_s <= known_s[0] <= known_s[-1] <= passage.until_s


def test_extremes_of_a_run_know_each_phase_that_took_time(
    report: Callable[[str], Report],
) -> None:
    it = report("patrol")
    found = run_extremes(it)

    assert set(found) == {each.key for each in it.passages if each.until_s > each.since_s}
    for each in found.values():
        lengths = {len(extremes.least) for extremes in each.curves.values()}
        assert len(lengths) == 1
        assert all(isinstance(extremes, Extremes) for extremes in each.curves.values())
