"""What earlier runs say about a run, on the page of its recording."""

from __future__ import annotations

from dataclasses import replace

from pirate_sm.running.recording.forecast_file import ForecastFile
from pirate_sm.views.report.contents import ExpectedEnd, Report, Sentence
from pirate_sm.views.report.expected_signals import with_bands
from pirate_sm.views.report.story import full_stop
from pirate_sm.views.report.timeline import PHASE


def with_expectations(report: Report, forecast: ForecastFile) -> Report:
    """Return the report of a run with what earlier runs say about it.

    The timeline shows when each phase was expected to end, and plots have bands behind their
    curves; phases that were slow are among what to look at.
    """
    times, signals = forecast.times, forecast.signals
    expected, slow = list[ExpectedEnd](), list[Sentence]()
    for key, since_s, until_s in report.passages:
        usual, words = times.usual(key), times.usual_words(key)
        if usual is not None and words:
            expected.append(ExpectedEnd(since_s + usual.low_s, since_s + usual.high_s, words))
        if words := times.slow_words(key, until_s - since_s):
            slow.append(Sentence(until_s, full_stop(words), "trouble", key.phase))
    lanes = (
        replace(lane, expected=tuple(expected)) if lane.name == PHASE else lane
        for lane in report.lanes
    )
    charts = report.charts
    if signals is not None:
        words = f"shaded: 90 % of {times.of(signals.runs)}, each moment by itself"
        charts = with_bands(charts, report.passages, signals.phases, words)
    said = full_stop(times.notice.capitalize())
    return replace(
        report,
        lanes=tuple(lanes),
        charts=charts,
        summary=(*report.summary, said),
        doubts=(*report.doubts, *slow),
    )
