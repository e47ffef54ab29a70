"""Compares two runs: their set-ups, and what happened, aligned by what the mission has reached.

The marks of a run are the phases that it enters, the commands that are done and the triggers that
fire. As long as both runs have the same marks in the same order they are aligned. Between two
marks, time is the share of the way from one mark to the next. So a robot that is slower than its
simulation is compared where it does the same.
"""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import isnan, sqrt
from pathlib import Path
from typing import Any, NamedTuple

from pirate_sm.core import effects as fx
from pirate_sm.core.events import SensorFrame
from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.replay import rerun
from pirate_sm.running.recording.signal_names import add_evenly

# --- two runs -------------------------------------------------------------------------------------


SAMPLES = 50
"""Number of compared instants between two marks."""

_MOST_KEPT = 60_000
"""The most frames of a run that are kept: all those of a quarter of an hour."""


@dataclass(frozen=True)
class Milestone:
    """A mark of a run."""

    what: str
    at_s: float


@dataclass
class ComparedRun:
    """The data of a run for the comparison.

    Attributes:
        times: Times of the frames; in a long run of some, evenly spaced. ``values`` are their
            signals, in the order of ``names``.
        kinds: The kind of each signal, such as a current; signals of one kind share a range.
        ending: How the run ended, with its message; empty if that is not recorded.
    """

    marks: list[Milestone] = field(default_factory=list)
    names: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    times: list[float] = field(default_factory=list)
    values: list[Sequence[float]] = field(default_factory=list)
    until_s: float = 0.0
    ending: str = ""

    def at(self, time_s: float) -> Sequence[float] | None:
        """Return the last known signals at a time."""
        place = bisect_right(self.times, time_s) - 1
        return self.values[place] if place >= 0 else None


@dataclass(frozen=True)
class MissionLeg:
    """The durations between two marks in both runs, s."""

    mark: str
    first_s: float
    second_s: float
    lasted_first_s: float
    lasted_second_s: float


@dataclass(frozen=True)
class Deviation:
    """The deviation of a signal between the two runs.

    Attributes:
        most: The largest deviation, in the unit of the signal; ``typical`` is the root mean square.
        where: The mark before the largest deviation; ``at_s`` is its time in the first run.
        first: The value there in the first run; ``second`` in the second.
        kind: The kind of signal.
    """

    name: str
    most: float
    typical: float
    where: str
    at_s: float
    first: float
    second: float
    kind: str = ""


@dataclass(frozen=True)
class Comparison:
    """The comparison of two runs.

    Attributes:
        legs: The ways between common marks.
        parted: The next mark of each run after the last common one; None: all are common.
        deviations: Deviations of common signals, sorted by the typical deviation as a share of the
            range of their kind.
    """

    legs: tuple[MissionLeg, ...]
    parted: tuple[str, str] | None
    deviations: tuple[Deviation, ...]


def compared_run(recording: Recording, loaded: LoadedMission) -> ComparedRun:
    """Return the marks and signals of a run for a comparison.

    Raises:
        RecordingError: The recording is damaged.
    """
    vocabulary = loaded.robot.vocabulary
    kinds = tuple(str(vocabulary.types[name]) for name in vocabulary.numbers)
    apart_s = 0.0
    found = ComparedRun(names=vocabulary.numbers, kinds=kinds)
    fault = ""
    for again in rerun(recording, loaded, every_signal=True):
        at_s = again.at_s
        found.until_s = max(found.until_s, at_s)
        for effect in again.step.effects:
            if isinstance(effect, fx.Fault) and effect.handling == "stop":
                fault = effect.code
            what = _mark(effect, fault)
            if what:
                found.marks.append(Milestone(what, at_s))
            if isinstance(effect, fx.Ended):
                found.ending = f"{effect.outcome} ({effect.message})"
        if again.state is not None and isinstance(again.step.event, SensorFrame):
            new = at_s, array("d", again.state.sensing.shown)
            apart_s = add_evenly(found.times, found.values, new, apart_s, _MOST_KEPT)
    return found


def _mark(effect: fx.Effect, fault: str) -> str:
    """Return the mark that an effect is, empty if none; ``fault`` is the code of what stops it."""
    match effect:
        case fx.PhaseChange():
            return f"phase {effect.phase}"
        case fx.CommandStatus(status="done" | "failed" | "refused"):
            return f"{effect.name} {effect.status}"
        case fx.TriggerFired():
            return f"{effect.phase}: {effect.trigger} fired"
        case fx.Ended():
            why = effect.end or (fault if effect.outcome == "fault" else "")
            return f"{effect.outcome}: {why}" if why else effect.outcome
        case _:
            return ""


def compare(first: ComparedRun, second: ComparedRun) -> Comparison:
    """Return where two runs part, the duration of each leg, and the deviations of signals."""
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


def _legs(one: Sequence[Milestone], other: Sequence[Milestone]) -> Iterator[MissionLeg]:
    before = (0.0, 0.0)
    for a, b in zip(one, other, strict=True):
        yield MissionLeg(a.what, a.at_s, b.at_s, a.at_s - before[0], b.at_s - before[1])
        before = (a.at_s, b.at_s)


_MOST_OF_A_KIND = 3
"""So many signals of a kind are named: one motor that is slower moves all currents."""


def of_each_kind(deviations: Iterable[Deviation]) -> list[Deviation]:
    """Return the first few deviations of each kind of signal, in the same order."""
    taken: Counter[str] = Counter()
    found = []
    for each in deviations:
        taken[each.kind] += 1
        if taken[each.kind] <= _MOST_OF_A_KIND:
            found.append(each)
    return found


_SAME_S = 0.1
"""Two runs that differ by less in time have taken the same time."""


def story(first: ComparedRun, second: ComparedRun, found: Comparison) -> str:
    """Return in one sentence where two runs part, or what made one of them take longer.

    It says how each ended, unless both ended alike on the same course.
    """
    ends = "A {}, B {}".format(
        *(each.ending or "is not recorded to its end" for each in (first, second))
    )
    if found.parted is not None:
        last = found.legs[-1] if found.legs else None
        since = "immediately"
        if last is not None:
            since = f"after '{last.mark}' ({last.first_s:.1f} s, {last.second_s:.1f} s)"
        a, b = found.parted
        return f"A and B part {since}: A comes to '{a}', B to '{b}'; {ends}"
    if not (first.ending and second.ending):
        until = f"{first.until_s:.1f} s of A and {second.until_s:.1f} s of B"
        return f"A and B take the same course as far as it is recorded, {until}; {ends}"
    took = f"A and B take the same course{_pace(first, second, found)}"
    return took if first.ending == second.ending else f"{took}; {ends}"


def _pace(first: ComparedRun, second: ComparedRun, found: Comparison) -> str:
    """Return how long two runs of the same course took."""
    later_s = second.until_s - first.until_s
    slower = max(found.legs, key=lambda leg: abs(_later_s(leg)), default=None)
    most_s = 0.0 if slower is None else abs(_later_s(slower))
    if max(abs(later_s), most_s) < _SAME_S:
        return " in the same time"
    whole = f"; B takes {abs(later_s):.1f} s {'longer' if later_s > 0 else 'less'} than A"
    if slower is None:
        return whole
    lasted = f"{slower.lasted_first_s:.1f} s in A, {slower.lasted_second_s:.1f} s in B"
    return f"{whole}, mostly up to '{slower.mark}' ({lasted})"


def _later_s(leg: MissionLeg) -> float:
    return leg.lasted_second_s - leg.lasted_first_s


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

    def deviation(self, name: str, kind: str) -> Deviation:
        a, b = self.values
        return Deviation(name, self.most, self.typical, self.where, self.at_s, a, b, kind)

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
        (tally.typical / (spans[kind] or 1.0), tally.deviation(name, kind))
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


# --- two set-ups ----------------------------------------------------------------------------------


_NAMED_ALREADY = {"mission", "robot", "pipe", "backend", "fidelity", "detector", "settings"}
"""Options for which the header has the resulting value as well."""


class Unlike(NamedTuple):
    """A difference in the set-up of two runs.

    Attributes:
        name: Its name, such as ``seed`` or ``parameter give_up``.
        first: Its value in the first run, as text; ``second`` in the second.
    """

    name: str
    first: str
    second: str


def unlike(first: RunHeader, second: RunHeader) -> tuple[Unlike, ...]:
    """Return all differences in the set-up of two runs, except the times of their start."""
    one, other = dict(_circumstances(first)), dict(_circumstances(second))
    names = dict.fromkeys((*one, *other))
    return tuple(
        Unlike(name, _as_text(one.get(name)), _as_text(other.get(name)))
        for name in names
        if one.get(name) != other.get(name)
    )


def _circumstances(it: RunHeader) -> Iterator[tuple[str, Any]]:
    """Yield name and value of every item in the set-up of a run."""
    for name in ("mission", "robot", "polarity", "pipe", "backend", "fidelity", "detector"):
        yield name, getattr(it, name)
    for name, value in it.options.items():
        if name not in _NAMED_ALREADY:
            yield name.replace("_", " "), value
    for name, text in it.parameters.items():
        yield f"parameter {name}", text
    for name, zero_rad in it.zeros.items():
        yield f"zero of {name}", f"{zero_rad:.6g} rad"
    for file in it.files:
        name = file.role if file.role != "called" else f"called {Path(file.name).stem}"
        yield f"text of the {name}", f"{Path(file.name).name}, SHA-256 {file.sha256[:8]}…"
    yield "version", it.version


def _as_text(value: Any) -> str:
    """Return the value as text."""
    if value in (None, [], {}, ""):
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list) and all(isinstance(each, str) for each in value):
        return ", ".join(value)
    return f"{len(value)} given" if isinstance(value, list | dict) else str(value)
