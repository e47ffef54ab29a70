"""What earlier runs say about the times of a run, on the page of its recording."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from pirate_sm.running.recording.read.pieces import StepEffects
from pirate_sm.running.runtime.phase_times import EarlierRuns, PhaseKey, PhaseVisits
from pirate_sm.views.report.contents import ExpectedEnd, Report, Sentence
from pirate_sm.views.report.story import full_stop
from pirate_sm.views.report.timeline import PHASE


def with_expected_times(
    report: Report, steps: Iterable[StepEffects], forecast: EarlierRuns
) -> Report:
    """Return the report of a run with what earlier runs say about its times.

    The timeline shows when each phase was expected to end; phases that were slow are among what to
    look at.

    Args:
        report: The report.
        steps: The effects of its run.
        forecast: What earlier runs say.
    """
    expected, slow = list[ExpectedEnd](), list[Sentence]()
    for key, since_s, until_s in _passages(steps, report.duration_s):
        usual, words = forecast.usual(key), forecast.usual_words(key)
        if usual is not None and words:
            expected.append(ExpectedEnd(since_s + usual.low_s, since_s + usual.high_s, words))
        if words := forecast.slow_words(key, until_s - since_s):
            slow.append(Sentence(until_s, full_stop(words), "trouble", key.phase))
    lanes = (
        replace(lane, expected=tuple(expected)) if lane.name == PHASE else lane
        for lane in report.lanes
    )
    said = full_stop(forecast.notice.capitalize())
    return replace(
        report,
        lanes=tuple(lanes),
        summary=(*report.summary, said),
        doubts=(*report.doubts, *slow),
    )


def _passages(
    steps: Iterable[StepEffects], until_s: float
) -> Iterator[tuple[PhaseKey, float, float]]:
    """Yield each phase of the run, when it was entered and when it was left."""
    visits = PhaseVisits()
    for step in steps:
        key, since_s = visits.key, visits.since_s
        if visits.see(step.effects, step.at_s) and key is not None:
            yield key, since_s, step.at_s
    if visits.key is not None:
        yield visits.key, visits.since_s, until_s
