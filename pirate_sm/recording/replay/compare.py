"""Two runs side by side: lined up by what the mission has come to, not by the clock.

The marks of a run are the phases that it enters, the commands that are done and the triggers that
fire. As long as both runs have the same marks in the same order they are on one course; between
two marks, time counts from the first one as a share of the way to the second. So a robot that is
slower than its simulation is compared where it does the same.
"""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import isnan, sqrt

from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model import effects as fx
from pirate_sm.model.events import SensorFrame
from pirate_sm.recording.read.reader import Recording
from pirate_sm.recording.replay.replay import engine_of, rerun
from pirate_sm.recording.thinning import add_evenly

SAMPLES = 50
"""So many places between two marks are compared."""

_MOST_KEPT = 60_000
"""The most frames of a run that are compared: all those of a quarter of an hour."""


@dataclass(frozen=True)
class Milestone:
    """Something that a mission has come to."""

    what: str
    at_s: float


@dataclass
class ComparedRun:
    """A run as it is compared.

    Attributes:
        times: Of the frames, of a long run only of some, evenly; ``values`` their signals, in the
            order of ``names``.
        kinds: What each signal is, such as a current; for ranges that signals share.
    """

    marks: list[Milestone] = field(default_factory=list)
    names: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    times: list[float] = field(default_factory=list)
    values: list[Sequence[float]] = field(default_factory=list)
    ended: fx.Ended | None = None
    until_s: float = 0.0

    def at(self, time_s: float) -> Sequence[float] | None:
        """Return the signals as they were last known at a time."""
        place = bisect_right(self.times, time_s) - 1
        return self.values[place] if place >= 0 else None


@dataclass(frozen=True)
class Leg:
    """The way between two marks in both runs, s."""

    mark: str
    first_s: float
    second_s: float
    lasted_first_s: float
    lasted_second_s: float


@dataclass(frozen=True)
class Deviation:
    """How far a signal of the two runs is apart.

    Attributes:
        most: The largest distance, in the unit of the signal; ``typical`` its root mean square.
        where: After which mark it was largest; ``at_s`` when, in the first run.
        first: Its value there in the first run; ``second`` in the second.
    """

    name: str
    most: float
    typical: float
    where: str
    at_s: float
    first: float
    second: float


@dataclass(frozen=True)
class Comparison:
    """Two runs side by side.

    Attributes:
        legs: As long as they are on one course.
        parted: What each came to where they part, first and second; None: they do not.
        deviations: Of the signals of both, those first that are typically the farthest apart
            for what signals of their kind span.
    """

    legs: tuple[Leg, ...]
    parted: tuple[str, str] | None
    deviations: tuple[Deviation, ...]


def compared_run(recording: Recording, loaded: LoadedMission) -> ComparedRun:
    """Return the marks and signals of a run for a comparison.

    Raises:
        RecordingError: The recording is damaged.
    """
    engine = engine_of(recording, loaded)
    vocabulary = loaded.robot.vocabulary
    kinds = tuple(str(vocabulary.types[name]) for name in vocabulary.numbers)
    apart_s = 0.0
    found = ComparedRun(names=vocabulary.numbers, kinds=kinds)
    for again in rerun(recording, loaded):
        at_s = again.at_s
        found.until_s = max(found.until_s, at_s)
        for effect in again.step.effects:
            what = _mark(effect)
            if what:
                found.marks.append(Milestone(what, at_s))
            if isinstance(effect, fx.Ended):
                found.ended = effect
        if again.state is not None and isinstance(again.step.event, SensorFrame):
            new = at_s, array("d", engine.signals(again.state).values())
            apart_s = add_evenly(found.times, found.values, new, apart_s, _MOST_KEPT)
    return found


def _mark(effect: fx.Effect) -> str:
    match effect:
        case fx.PhaseChange():
            return f"phase {effect.phase}"
        case fx.CommandStatus(status="done" | "failed" | "refused"):
            return f"{effect.name} {effect.status}"
        case fx.TriggerFired():
            return f"{effect.phase}: {effect.trigger} fired"
        case fx.Ended():
            return f"{effect.outcome}: {effect.end}" if effect.end else effect.outcome
        case _:
            return ""


def compare(first: ComparedRun, second: ComparedRun) -> Comparison:
    """Return where two runs part, the duration of each leg, and how far signals are apart."""
    common = 0
    for one, other in zip(first.marks, second.marks, strict=False):
        if one.what != other.what:
            break
        common += 1
    legs = tuple(_legs(first.marks[:common], second.marks[:common]))
    parted = None
    if common < max(len(first.marks), len(second.marks)):
        parted = _next(first, common), _next(second, common)
    return Comparison(legs, parted, _deviations(first, second, common))


def _next(course: ComparedRun, place: int) -> str:
    return course.marks[place].what if place < len(course.marks) else "nothing more"


def _legs(one: Sequence[Milestone], other: Sequence[Milestone]) -> Iterator[Leg]:
    before = (0.0, 0.0)
    for a, b in zip(one, other, strict=True):
        yield Leg(a.what, a.at_s, b.at_s, a.at_s - before[0], b.at_s - before[1])
        before = (a.at_s, b.at_s)


@dataclass
class _Tally:
    most: float = -1.0
    squares: float = 0.0
    count: int = 0
    low: float = 0.0
    high: float = 0.0
    where: str = ""
    at_s: float = 0.0
    values: tuple[float, float] = (0.0, 0.0)

    @property
    def typical(self) -> float:
        return sqrt(self.squares / self.count)

    def deviation(self, name: str) -> Deviation:
        a, b = self.values
        return Deviation(name, self.most, self.typical, self.where, self.at_s, a, b)

    def add(self, a: float, b: float, where: str, at_s: float) -> None:
        if isnan(a) or isnan(b):
            return
        apart = abs(a - b)
        self.low, self.high = min(self.low, a, b), max(self.high, a, b)
        self.squares, self.count = self.squares + apart * apart, self.count + 1
        if apart > self.most:
            self.most, self.where, self.at_s, self.values = apart, where, at_s, (a, b)


def _deviations(first: ComparedRun, second: ComparedRun, common: int) -> tuple[Deviation, ...]:
    shared = [name for name in first.names if name in second.names]
    here = [first.names.index(name) for name in shared]
    there = [second.names.index(name) for name in shared]
    tallies = [_Tally() for _ in shared]
    for where, a_s, b_s in _places(first, second, common):
        a, b = first.at(a_s), second.at(b_s)
        if a is None or b is None:
            continue
        for tally, i, k in zip(tallies, here, there, strict=True):
            tally.add(a[i], b[k], where, a_s)
    kinds = [first.kinds[index] if first.kinds else "" for index in here]
    spans: dict[str, float] = {}
    for kind, tally in zip(kinds, tallies, strict=True):
        spans[kind] = max(spans.get(kind, 0.0), tally.high - tally.low)
    found = [
        (tally.typical / (spans[kind] or 1.0), tally.deviation(name))
        for name, kind, tally in zip(shared, kinds, tallies, strict=True)
        if tally.count
    ]
    found.sort(key=lambda each: (-each[0], each[1].name))
    return tuple(deviation for _, deviation in found)


def _places(
    first: ComparedRun, second: ComparedRun, common: int
) -> Iterator[tuple[str, float, float]]:
    """Yield times of both runs at the same shares of the way between the same marks."""
    marks = list(zip(first.marks[:common], second.marks[:common], strict=True))
    for (a, b), (next_a, next_b) in pairwise(marks):
        for number in range(SAMPLES):
            share = number / SAMPLES
            a_s = a.at_s + share * (next_a.at_s - a.at_s)
            b_s = b.at_s + share * (next_b.at_s - b.at_s)
            yield a.what, a_s, b_s
