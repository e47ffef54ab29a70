"""Counts the runs of a cell in the order of its seeds, and decides when they are enough.

Results come in any order. Only the complete beginning of the seeds counts, run by run, so neither
the counts nor the end of a cell depend on which run was faster.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import isnan, nan

from pirate_sm.lab.campaign.campaign_model import StoppingRule
from pirate_sm.lab.campaign.chunk import RunRow, factors_of
from pirate_sm.lab.campaign.intervals import Interval, wilson
from pirate_sm.lab.campaign.plan import Cell
from pirate_sm.lab.campaign.sensitivity import RunOutcome
from pirate_sm.lab.campaign.sensitivity_model import Factor
from pirate_sm.lab.campaign.sequential import REFUSED, SequentialTest, Verdict

_MOST_SEEDS = 100
"""The most seeds that are kept for each cause."""

_MEASURED = re.compile(
    r"(?<![\w.])-?\d+\.\d+|(?<![\w.])-?\d+(?= (?:s|ms|mm|m|deg|rad/s|Nm|mNm|%|Hz|V|A|mA)\b)"
)
"""Numbers in a message that differ from run to run."""


_BINS = 10
"""The number of equal parts of a factor's range."""


@dataclass
class FactorCount:
    """How many runs passed in each part of the range of a factor.

    Attributes:
        factor: What is drawn.
        runs: The runs in each part; likewise ``passed``.
    """

    factor: Factor
    runs: list[int] = field(default_factory=lambda: [0] * _BINS)
    passed: list[int] = field(default_factory=lambda: [0] * _BINS)

    def count(self, value: float, passed: bool) -> None:
        """Count a run with this value of the factor."""
        _, _, low, high = self.factor
        part = int((value - low) / (high - low) * _BINS)
        if not 0 <= part < _BINS:
            part = 0 if part < 0 else _BINS - 1
        self.runs[part] += 1
        self.passed[part] += passed

    def edges(self) -> list[float]:
        """Return where the parts begin, and where the last one ends."""
        _, _, low, high = self.factor
        return [low + (high - low) * part / _BINS for part in range(_BINS + 1)]


@dataclass
class Cause:
    """Why runs of a cell did not pass.

    Attributes:
        verdict: What they were, in truth.
        why: The reason, as the first of these runs gives it.
        varies: Whether the numbers in the reason are others in other runs.
        count: How many runs.
        seeds: The first of their seeds.
        drawn: What the first of them has drawn.
    """

    verdict: str
    why: str
    varies: bool = False
    count: int = 0
    seeds: list[int] = field(default_factory=list)
    drawn: Mapping[str, float] = field(default_factory=dict)


@dataclass
class Tally:
    """The results of a cell that count.

    Attributes:
        cell: The cell.
        confidence: Of the interval.
        stop: When it has had enough runs.
        test: Ends it too; None: only those.
        runs: How many runs count.
        passed: How many of them passed; likewise ``held``, ``false``, ``unsafe`` and ``bugs``.
        refused: How many could not begin.
        passes: For each run in the order of the seeds whether it passed, 1 or 0.
        times_s: Mission time of each run that passed; ``others_s`` of each other one.
        factors: How success goes with what runs have drawn.
        deepest_m: How deep a wheel or link was in a wall, at most; below zero if unknown.
        farthest_short_m: How far a wheel was short of where the last word says, at most, in runs
            that passed; None if no word was said.
        unsafe_causes: Which rules of safety were broken.
        causes: Why the others did not pass, by verdict and reason.
        outcomes: The outcome of each run and the numbers of its robot, if these are varied.
        decided: Whether no further run counts.
    """

    cell: Cell
    confidence: float
    stop: StoppingRule
    test: SequentialTest | None = None
    runs: int = 0
    passed: int = 0
    held: int = 0
    false: int = 0
    unsafe: int = 0
    bugs: int = 0
    refused: int = 0
    deepest_m: float = -1.0
    farthest_short_m: float | None = None
    passes: bytearray = field(default_factory=bytearray)
    times_s: array[float] = field(default_factory=lambda: array("d"))
    others_s: array[float] = field(default_factory=lambda: array("d"))
    factors: tuple[FactorCount, ...] = ()
    causes: dict[tuple[str, str], Cause] = field(default_factory=dict)
    unsafe_causes: dict[tuple[str, str], Cause] = field(default_factory=dict)
    outcomes: list[tuple[RunOutcome, Sequence[float]]] = field(default_factory=list)
    decided: bool = False
    _waiting: dict[int, RunRow] = field(default_factory=dict)
    _positions: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.factors:
            design = self.cell.design
            varied = (*factors_of(self.cell.order), *self.cell.sampled)
            self.factors = tuple(map(FactorCount, (*varied, *(design.numbers if design else ()))))
        if not isinstance(self.cell.seeds, range):
            self._positions = {seed: n for n, seed in enumerate(self.cell.seeds)}

    @property
    def interval(self) -> Interval:
        """The interval of its success; once a test has ended it, that of the test."""
        if self.test is not None and self.verdict not in (None, REFUSED):
            return self.test.interval(self.passed, self.runs, self.confidence)
        return wilson(self.passed, self.runs, self.confidence)

    @property
    def verdict(self) -> Verdict | None:
        """What its test says; None: there is none, or it has not ended.

        A run that cannot begin ends it: that says nothing about the mission.
        """
        if self.test is None:
            return None
        return REFUSED if self.refused else self.test.verdict(self.passed, self.runs)

    @property
    def violated(self) -> bool:
        """Whether the cell is not as expected; of one under way: whether it can no longer be."""
        return bool(self.missed())

    def missed(self) -> tuple[str, ...]:
        """Return which expectations are missed, whatever the seeds that are left do."""
        expect, left = self.cell.expect, 0 if self.decided else len(self.cell.seeds) - self.runs
        shares = (
            ("success", expect.success, self.passed),
            ("holding", expect.holding, self.held),
            ("truthful", expect.truthful, self.runs - self.false),
            ("safe", expect.safe, self.runs - self.unsafe),
        )
        most = self.runs + left
        return tuple(
            name
            for name, share, count in shares
            # A share of a count may be off by a rounding error.
            if share is not None and count + left < share * most - 1e-9
        )

    def add(self, rows: Iterable[RunRow]) -> None:
        """Take in results, in any order; those that come twice or too late change nothing."""
        for row in rows:
            position = self._position(row.seed)
            if position is not None and position >= self.runs:
                self._waiting.setdefault(position, row)
        while not self.decided and (row_ := self._waiting.pop(self.runs, None)) is not None:
            self._count(row_)
            self._decide()
        if self.decided:
            self._waiting.clear()

    @property
    def done(self) -> int:
        """How many seeds have a result, though one before them may have none yet."""
        return self.runs + len(self._waiting)

    @property
    def without_result(self) -> int:
        """How many seeds have no result, of a cell that is not decided."""
        return 0 if self.decided else len(self.cell.seeds) - self.done

    def missing(self, begin: int) -> Iterator[int]:
        """Yield the positions, from one on, of seeds that have no result."""
        for position in range(max(begin, self.runs), len(self.cell.seeds)):
            if position not in self._waiting:
                yield position

    def _position(self, seed: int) -> int | None:
        seeds: Sequence[int] = self.cell.seeds
        if isinstance(seeds, range):
            return seeds.index(seed) if seed in seeds else None
        return self._positions.get(seed)

    def _count(self, row: RunRow) -> None:
        self.runs += 1
        passed = row.verdict == "passed"
        self.passed += passed
        self.passes.append(passed)
        self.held += row.held
        self.false += row.verdict == "false"
        self.bugs += row.verdict == "bug"
        self.refused += row.outcome == "refused"
        self.unsafe += bool(row.unsafe)
        self.deepest_m = max(self.deepest_m, row.deepest_m)
        drawn = row.drawn
        for each in self.factors:
            if (value := drawn.get(each.factor.name)) is not None:
                each.count(value, passed)
        if self.cell.design is not None:
            numbers = [drawn.get(each.name, nan) for each in self.cell.design.numbers]
            unknown = row.outcome in ("refused", "bug")  # nothing was run, or not by the robot
            outcome = RunOutcome(nan if unknown else passed, row.time_s, row.slip_m)
            self.outcomes.append((outcome, numbers))
        if passed:
            self.times_s.append(row.time_s)
            if not isnan(row.short_m):
                known_m = self.farthest_short_m
                self.farthest_short_m = (
                    row.short_m if known_m is None else max(known_m, row.short_m)
                )
        else:
            self.others_s.append(row.time_s)
            tested = self.test is not None and row.outcome == "refused"
            _note(self.causes, REFUSED if tested else row.verdict, row.why, row)
        if row.unsafe:
            _note(self.unsafe_causes, "unsafe", row.unsafe, row)

    def _decide(self) -> None:
        limit = self.stop.half_width
        self.decided = (
            self.runs == len(self.cell.seeds)
            or (limit is not None and self.interval.half_width <= limit)
            or (self.stop.violated and self.violated)
            or self.verdict is not None
        )


def _note(causes: dict[tuple[str, str], Cause], verdict: str, why: str, row: RunRow) -> None:
    alike = _MEASURED.sub("…", why)
    cause = causes.setdefault((verdict, alike), Cause(verdict, why, drawn=row.drawn))
    cause.count += 1
    cause.varies |= why != cause.why
    if len(cause.seeds) < _MOST_SEEDS:
        cause.seeds.append(row.seed)
