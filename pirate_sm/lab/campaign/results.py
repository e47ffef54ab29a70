"""The results of a campaign, cell by cell, as data and as text for people."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from types import MappingProxyType
from typing import Any

from pirate_sm.core.on_disk import is_there
from pirate_sm.lab.campaign.campaign_model import Expectation
from pirate_sm.lab.campaign.conductor import recording_name
from pirate_sm.lab.campaign.intervals import wilson
from pirate_sm.lab.campaign.margins import CellMargins, FactorMargin, PairMap, margin_lines
from pirate_sm.lab.campaign.plan import CampaignPlan, command_of, varied
from pirate_sm.lab.campaign.sensitivity import Decided, decided_or_why
from pirate_sm.lab.campaign.store import RECORDINGS
from pirate_sm.lab.campaign.tally import Cause, FactorCount, Tally

_MOST_SEEDS = 10
"""The most seeds of a cause that are printed."""

_BARS = 30
"""The bars of a histogram."""


@dataclass(frozen=True)
class CauseResult:
    """Why runs did not pass, or were not safe.

    Attributes:
        verdict: ``failed``, ``false``, ``bug``, ``unsafe`` or, with margins, ``refused``.
        why: The reason, as the first of these runs gives it.
        varies: Whether the numbers in the reason are others in other runs.
        count: How many runs.
        seeds: The first of their seeds.
        command: Repeats the first of them.
        recordings: Paths of the recordings of seeds that have one, by seed.
    """

    verdict: str
    why: str
    varies: bool
    count: int
    seeds: tuple[int, ...]
    command: str
    recordings: Mapping[int, str]

    @property
    def recording(self) -> str:
        """Path of the recording of its first run; empty if there is none."""
        return self.recordings.get(self.seeds[0], "")


@dataclass(frozen=True)
class FactorResult:
    """How success goes with a number that each run draws, in equal parts of its range.

    Attributes:
        name: Of the factor; ``unit`` is empty for a share.
        edges: Where the parts begin, and where the last one ends.
        runs: How many runs are in each part; likewise ``passed``.
        least: Least share of the interval of success in each part; likewise ``most``.
    """

    name: str
    unit: str
    edges: tuple[float, ...]
    runs: tuple[int, ...]
    passed: tuple[int, ...]
    least: tuple[float, ...]
    most: tuple[float, ...]


@dataclass(frozen=True)
class TimeCounts:
    """How many runs have taken how long, in bars of equal width.

    Attributes:
        edges_s: Where the bars begin, and where the last one ends.
        passed: How many runs of each bar passed; likewise ``others`` that did not.
    """

    edges_s: tuple[float, ...]
    passed: tuple[int, ...]
    others: tuple[int, ...]


@dataclass(frozen=True)
class CellResult:
    """The result of a cell.

    Attributes:
        name: Its name, made of ``row`` and ``column``.
        values: What its runs have in common, by name.
        runs: How many runs count.
        of: How many seeds it has.
        passed: How many passed; likewise ``held``, ``false``, ``unsafe`` and ``bugs``, of
            which those at other values of its factors are some, too.
        without_result: How many seeds have no result though they are needed, as the campaign was
            interrupted or results are damaged; ``first_without`` is the first of them. The runs of
            the seeds after that do not count.
        least: Least share of the interval of its success; likewise ``most``. None without runs.
        times_s: Least, median and most mission time of the runs that passed; empty if none did.
        farthest_short_m: How far a wheel was short of where the detector's last word says, at most.
        deepest_m: How deep a wheel or link was in a wall, at most.
        expected: What is expected of it, in words.
        missed: Which of it is missed.
        causes: Why runs did not pass, or were not safe; the most frequent first.
        factors: How success goes with what runs draw.
        took: How long runs have taken; None without runs.
        decided: Which numbers of the robot decide the outcome of its runs, if these are varied.
        not_decided: Why that is not known; empty if it is.
        margins: How far it holds when one factor changes, if that is asked; likewise ``maps`` when
            two do.
        open_levels: How many of the values of these have no result yet.
        level_runs: How many runs there are at the others.
    """

    name: str
    row: str
    column: str
    values: Mapping[str, str]
    runs: int
    of: int
    passed: int
    held: int
    false: int
    unsafe: int
    bugs: int
    without_result: int
    first_without: int | None
    least: float | None
    most: float | None
    times_s: tuple[float, ...]
    farthest_short_m: float | None
    deepest_m: float | None
    expected: str
    missed: tuple[str, ...]
    causes: tuple[CauseResult, ...]
    factors: tuple[FactorResult, ...]
    took: TimeCounts | None
    decided: tuple[Decided, ...] = ()
    not_decided: str = ""
    margins: tuple[FactorMargin, ...] = ()
    maps: tuple[PairMap, ...] = ()
    open_levels: int = 0
    level_runs: int = 0

    @property
    def share(self) -> float | None:
        """The share that passed; None without runs."""
        return self.passed / self.runs if self.runs else None

    @property
    def summary(self) -> str:
        """How many runs passed, with the interval of their share."""
        if self.least is None or self.most is None:
            return "no runs"
        return f"{self.passed:,} of {self.runs:,} passed, {self.least:.1%} to {self.most:.1%}"

    @property
    def incomplete(self) -> str:
        """What is missing of the cell; empty if nothing is."""
        if not self.without_result and self.open_levels:
            return (
                f"not complete: {self.open_levels:,} values of its factors have no result yet; the "
                "campaign's command with --resume runs them"
            )
        if not self.without_result:
            return ""
        return (
            f"not complete: no result for {self.without_result:,} of {self.of:,} seeds, the first "
            f"is {self.first_without}; later ones do not count until the campaign's command with "
            "--resume has run it"
        )

    @property
    def good(self) -> bool:
        """Whether nothing speaks against the cell: no missed expectation, no exception."""
        return not self.missed and not self.bugs


@dataclass(frozen=True)
class CampaignResult:
    """The result of a campaign.

    Attributes:
        name: Name of the campaign.
        results: The folder of its results.
        version: Of the code that has run it.
        confidence: Of the intervals.
        cells: The cells that count.
        left_out: Names of the cells that were not run, because one before is not as expected.
    """

    name: str
    results: str
    version: str
    confidence: float
    cells: tuple[CellResult, ...]
    left_out: tuple[str, ...]

    @property
    def good(self) -> bool:
        """Whether every cell is complete and good."""
        return all(cell.good and not cell.incomplete for cell in self.cells)

    @property
    def summary(self) -> str:
        """How many runs there are, and how many cells are not as expected or not complete."""
        runs = sum(cell.runs + cell.level_runs for cell in self.cells)
        below = sum(not cell.good for cell in self.cells)
        short = sum(bool(cell.incomplete) for cell in self.cells)
        cells = "1 cell" if len(self.cells) == 1 else f"{len(self.cells)} cells"
        found = [f"{below} not as expected"] if below else []
        found += [f"{short} not complete"] if short else []
        return f"{runs:,} runs of {cells}: {', '.join(found) or 'as expected'}"

    def as_data(self) -> dict[str, Any]:
        """Return the result as plain data."""
        return {"good": self.good, **asdict(self)}


def result_of(
    plan: CampaignPlan,
    tallies: Sequence[Tally],
    folder: Path,
    margins: Mapping[str, CellMargins] = MappingProxyType({}),
) -> CampaignResult:
    """Return the result of a campaign.

    Args:
        plan: The campaign.
        tallies: The counts of the cells that count, in the order of the plan.
        folder: The folder of its results.
        margins: How far its cells hold, by their keys, if that was asked.
    """
    cells = tuple(
        _cell(tally, folder / RECORDINGS, margins.get(tally.cell.key)) for tally in tallies
    )
    left_out = tuple(cell.name for cell in plan.cells[len(cells) :])
    return CampaignResult(plan.name, str(folder), plan.version, plan.confidence, cells, left_out)


def _cell(tally: Tally, recordings: Path, margins: CellMargins | None) -> CellResult:
    cell, times_s = tally.cell, tally.times_s
    least, most = tally.interval if tally.runs else (None, None)
    found = sorted(tally.causes.values(), key=_frequent)
    found += sorted(tally.unsafe_causes.values(), key=_frequent)
    return CellResult(
        cell.name,
        cell.row,
        cell.column,
        cell.values,
        tally.runs,
        len(cell.seeds),
        tally.passed,
        tally.held,
        tally.false,
        tally.unsafe,
        tally.bugs + (margins.bugs if margins else 0),
        tally.without_result,
        cell.seeds[tally.runs] if tally.without_result else None,
        least,
        most,
        (min(times_s), median(times_s), max(times_s)) if times_s else (),
        tally.farthest_short_m,
        tally.deepest_m if tally.deepest_m >= 0.0 else None,
        _expected(cell.expect),
        (*tally.missed(), *(margins.missed if margins else ())),
        tuple(_cause(tally, each, recordings) for each in found),
        tuple(_factor(each, tally.confidence) for each in tally.factors if any(each.runs)),
        _took(tally.times_s, tally.others_s),
        *decided_or_why(cell.design, tally.outcomes, tally.confidence),
        *((margins.factors, margins.pairs, len(margins.wanted), margins.runs) if margins else ()),
    )


def _factor(count: FactorCount, confidence: float) -> FactorResult:
    shares = [wilson(*each, confidence) for each in zip(count.passed, count.runs, strict=True)]
    return FactorResult(
        count.factor.name,
        count.factor.unit,
        tuple(count.edges()),
        tuple(count.runs),
        tuple(count.passed),
        tuple(each.least for each in shares),
        tuple(each.most for each in shares),
    )


def _took(passed_s: Sequence[float], others_s: Sequence[float]) -> TimeCounts | None:
    every_s = (*passed_s, *others_s)
    if not every_s:
        return None
    least_s, most_s = min(every_s), max(every_s)
    width_s = (most_s - least_s) / _BARS or 1.0

    def counts(times_s: Sequence[float]) -> tuple[int, ...]:
        bars = Counter(min(int((each - least_s) / width_s), _BARS - 1) for each in times_s)
        return tuple(bars[bar] for bar in range(_BARS))

    edges_s = tuple(least_s + bar * width_s for bar in range(_BARS + 1))
    return TimeCounts(edges_s, counts(passed_s), counts(others_s))


def _frequent(cause: Cause) -> tuple[int, str]:
    return -cause.count, cause.why


def _cause(tally: Tally, cause: Cause, recordings: Path) -> CauseResult:
    order = varied(tally.cell, cause.seeds[0], cause.drawn)
    places = {seed: recordings / recording_name(tally, seed) for seed in cause.seeds}
    return CauseResult(
        cause.verdict,
        cause.why,
        cause.varies,
        cause.count,
        tuple(cause.seeds),
        command_of(order, order.seed),
        {seed: str(place) for seed, place in places.items() if is_there(place)},
    )


def _expected(expect: Expectation) -> str:
    shares = expect.model_dump(exclude_none=True)
    return ", ".join(f"{name} >= {100 * share:.12g} %" for name, share in shares.items())


def as_text(result: CampaignResult) -> str:
    """Return the result as lines for people."""
    return "\n".join(_lines(result)) + "\n"


def _lines(result: CampaignResult) -> Iterator[str]:
    width = max((len(cell.name) for cell in result.cells), default=0)
    interval = f"{result.confidence:.0%} interval"
    yield f"{'':{width}}  {'passed':>20}  {interval:>16}  mission time, least/median/most"
    for cell in result.cells:
        if cell.share is None:
            yield f"{cell.name:{width}}  {'no runs':>20}"
            yield f"    {cell.incomplete}"
            continue
        shares = f"{cell.least:.1%} to {cell.most:.1%}"
        times = "/".join(f"{each:.1f}" for each in cell.times_s)
        count = f"{cell.passed:,} of {cell.runs:,}"
        missed = f"  BELOW EXPECTED: {', '.join(cell.missed)}" if cell.missed else ""
        yield (
            f"{cell.name:{width}}  {count:>13} {cell.share:6.1%}  {shares:>16}"
            f"  {times + ' s' if times else '-'}{missed}"
        )
        if cell.incomplete:
            yield f"    {cell.incomplete}"
        for cause in cell.causes:
            yield from _cause_lines(cause)
        if cell.not_decided:
            yield f"    no indices: {cell.not_decided}"
        for each in cell.decided:
            yield from _decided_lines(each)
        yield from (f"    {line}" for line in margin_lines(cell.margins, cell.maps))
    for name in result.left_out:
        yield f"{name}: not run, a cell before it is not as expected"
    yield result.summary
    yield f"results in {shlex.quote(result.results)}"


def _decided_lines(found: Decided) -> Iterator[str]:
    """Yield which numbers decide an outcome, with the indices of the method and intervals."""
    width = max((len(each.name) for each in found.numbers), default=0)
    yield f"    {found.outcome}: {found.summary}"
    for each in found.numbers:
        yield f"        {each.name:{width}}  {each.words}"


def _cause_lines(cause: CauseResult) -> Iterator[str]:
    shown = ", ".join(map(str, cause.seeds[:_MOST_SEEDS]))
    more = ", …" if cause.count > _MOST_SEEDS else ""
    numbers = f"; numbers of seed {cause.seeds[0]}" if cause.varies else ""
    yield f"    {cause.count:5,} × {cause.verdict}: {cause.why} (seeds {shown}{more}{numbers})"
    yield f"            {cause.command}"
    if cause.recording:
        yield f"            recorded in {shlex.quote(cause.recording)}"
