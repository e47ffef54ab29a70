"""Two runs in one report: the second is laid over the first, at the times of the first.

Between two marks that both runs have reached, such as a phase, time of the second is stretched to
that of the first. Where only one of them has marks, its time runs on as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pirate_sm.core.expressions import Vocabulary
from pirate_sm.core.units import format_quantity
from pirate_sm.running.recording.compare import (
    Comparison,
    Deviation,
    MissionLeg,
    compare,
    compared_run,
    of_each_kind,
    story,
    unlike,
)
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.views.report.contents import Chart, Fact, Lane, Report, Sentence, Series
from pirate_sm.views.report.recording_report import report_of

_MOST_NAMED = 8
"""So many differences of signals are named; the plots show all."""

_LANES = ("phase", "commands", "waits for", "triggers", "detector", "operator", "faults")
"""The lanes of the second run that are shown with those of the first."""


class Alignment:
    """Turns times of the second run into times of the first.

    Args:
        legs: The ways between marks that both have reached.
    """

    def __init__(self, legs: Sequence[MissionLeg]) -> None:
        knots = {0.0: 0.0} | {leg.second_s: leg.first_s for leg in legs}
        self._theirs, self._ours = np.array([*knots]), np.array([*knots.values()])

    def __call__(self, times_s: Sequence[float]) -> list[float]:
        """Return the times in the first run."""
        given = np.asarray(times_s, dtype=np.float64)
        beyond = np.maximum(given - self._theirs[-1], 0.0)
        found: list[float] = (np.interp(given, self._theirs, self._ours) + beyond).tolist()
        return found

    def at(self, time_s: float) -> float:
        """Return the time in the first run."""
        return self([time_s])[0]


@dataclass(frozen=True)
class SecondRun:
    """The second of two runs.

    Attributes:
        report: Its own report.
        clock: Its times in the first run.
    """

    report: Report
    clock: Alignment


def compared_report(first: Recording, second: Recording) -> Report:
    """Return the report of two runs.

    Raises:
        RecordingError: A recording is damaged, or of a version that cannot be read any more.
    """
    courses = []
    for recording in (first, second):
        with recorded_mission(recording.header) as loaded:
            courses.append(compared_run(recording, loaded))
            vocabulary = loaded.robot.vocabulary
    found = compare(*courses)
    one, other, clock = report_of(first), report_of(second), Alignment(found.legs)
    apart = [each for each in found.deviations if each.most > 0]
    setups = unlike(first.header, second.header)
    return replace(
        one,
        title=f"A: {one.title}, B: {other.title}" if one.title != other.title else one.title,
        summary=(f"{story(courses[0], courses[1], found)}.", *_summaries(one, other)),
        story=tuple(_stories(one, other, clock)),
        warnings=tuple(_named(one.warnings, other.warnings)),
        duration_s=max(one.duration_s, clock.at(other.duration_s)),
        lanes=tuple(_lanes(one, other, clock)),
        charts=_charts(one, other, clock, apart),
        facts=(*(Fact(each.name, f"{each.first} in A, {each.second} in B") for each in setups),)
        or (Fact("set-up", "the same seed, parameters and files in A and B"),),
        failures=tuple(replace_text(each, f"A: {each.text}") for each in one.failures),
        doubts=tuple(_differences(apart, vocabulary, found)),
        recording="",
        other=SecondRun(other, clock),
    )


def replace_text(it: Sentence, text: str) -> Sentence:
    """Return the sentence with another text."""
    return it._replace(text=text)


def _summaries(one: Report, other: Report) -> Iterator[str]:
    for name, report in (("A", one), ("B", other)):
        yield f"{name}: {' '.join(report.summary[:2])}"


def _named(one: Sequence[str], other: Sequence[str]) -> Iterator[str]:
    yield from (f"A: {line}" for line in one)
    yield from (f"B: {line}" for line in other)


def _stories(one: Report, other: Report, clock: Alignment) -> Iterator[Sentence]:
    """Yield the sentences of both, in the order of their times in the first run."""
    theirs = (
        each._replace(at_s=clock.at(each.at_s), text=f"B, at {each.at_s:.2f} s: {each.text}")
        for each in other.story
    )
    ours = (replace_text(each, f"A: {each.text}") for each in one.story)
    yield from sorted((*ours, *theirs), key=lambda each: each.at_s)


def _lanes(one: Report, other: Report, clock: Alignment) -> Iterator[Lane]:
    theirs = {lane.name: lane for lane in other.lanes}
    names = [lane.name for lane in one.lanes]
    yield from (lane for name in names for lane in _pair(name, one, theirs, clock))
    rest = [name for name in _LANES if name in theirs and name not in names]
    yield from (_moved(theirs[name], clock) for name in rest)


def _pair(name: str, one: Report, theirs: dict[str, Lane], clock: Alignment) -> Iterator[Lane]:
    yield next(lane for lane in one.lanes if lane.name == name)
    if name in _LANES and name in theirs:
        yield _moved(theirs[name], clock)


def _moved(lane: Lane, clock: Alignment) -> Lane:
    spans = tuple(
        each._replace(start_s=clock.at(each.start_s), end_s=clock.at(each.end_s))
        for each in lane.spans
    )
    marks = tuple(each._replace(at_s=clock.at(each.at_s)) for each in lane.marks)
    return Lane(f"{lane.name} of B", spans, marks)


def _charts(
    one: Report, other: Report, clock: Alignment, apart: Sequence[Deviation]
) -> tuple[Chart, ...]:
    """Return the plots with the curves of both, those that differ most first."""
    ranks = {each.name: rank for rank, each in enumerate(apart)}
    theirs = {chart.title: chart for chart in other.charts}
    found = [
        (
            min((ranks.get(each.name, len(ranks)) for each in chart.series), default=len(ranks)),
            replace(chart, series=tuple(_curves(chart, theirs.get(chart.title), clock))),
        )
        for chart in one.charts
    ]
    return tuple(chart for _, chart in sorted(found, key=lambda each: each[0]))


def _curves(chart: Chart, other: Chart | None, clock: Alignment) -> Iterator[Series]:
    places = {each.name: place for place, each in enumerate(chart.series)}
    yield from (replace(each, name=f"{each.name} A") for each in chart.series)
    for each in other.series if other is not None else ():
        if each.name in places:
            times_s = clock(each.times_s)
            name = f"{each.name} B"
            yield replace(each, name=name, times_s=times_s, like=places[each.name])


def _differences(
    apart: Sequence[Deviation], vocabulary: Vocabulary, found: Comparison
) -> Iterator[Sentence]:
    for each in of_each_kind(apart)[:_MOST_NAMED]:
        dimension = vocabulary.dimension(each.name)
        most, a, b = (
            format_quantity(float(f"{value:.3g}"), dimension)
            for value in (each.most, each.first, each.second)
        )
        text = f"{each.name} differs by up to {most}: {a} in A, {b} in B (after '{each.where}')"
        yield Sentence(each.at_s, text, "trouble")
