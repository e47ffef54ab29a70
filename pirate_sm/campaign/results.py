"""The results of a campaign, cell by cell, as data, and as text for people."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

from pirate_sm.campaign.plan import Plan, command_of
from pirate_sm.campaign.recorded_run import recording_name
from pirate_sm.campaign.tally import Cause, Tally
from pirate_sm.model.campaign import Expectation

_MOST_SEEDS = 10
"""The most seeds of a cause that are printed."""


@dataclass(frozen=True)
class CauseResult:
    """Why runs did not pass, or were not safe.

    Attributes:
        verdict: ``failed``, ``false``, ``bug`` or ``unsafe``.
        why: The reason.
        count: How many runs.
        seeds: The first of their seeds.
        command: Repeats the first of them.
        recording: Path of its recording, from the folder of the results; empty if there is none.
    """

    verdict: str
    why: str
    count: int
    seeds: tuple[int, ...]
    command: str
    recording: str


@dataclass(frozen=True)
class CellResult:
    """The result of a cell.

    Attributes:
        name: Its name, made of ``row`` and ``column``.
        runs: How many runs count.
        of: How many seeds it has.
        passed: How many passed; likewise ``held``, ``false``, ``unsafe`` and ``bugs``.
        least: Least share of the interval of its success; likewise ``most``.
        times_s: Least, median and most mission time of the runs that passed; empty if none did.
        farthest_short_m: How far a wheel was short of where the detector's last word says, at most.
        deepest_m: How deep a wheel or link was in a wall, at most.
        expected: What is expected of it, in words.
        missed: Which of it is missed.
        causes: Why runs did not pass, or were not safe; the most frequent first.
    """

    name: str
    row: str
    column: str
    runs: int
    of: int
    passed: int
    held: int
    false: int
    unsafe: int
    bugs: int
    least: float
    most: float
    times_s: tuple[float, ...]
    farthest_short_m: float | None
    deepest_m: float | None
    expected: str
    missed: tuple[str, ...]
    causes: tuple[CauseResult, ...]

    @property
    def share(self) -> float:
        """The share that passed; 0 without runs."""
        return self.passed / self.runs if self.runs else 0.0

    @property
    def good(self) -> bool:
        """Whether the cell is as expected, and this program has raised no exception."""
        return not self.missed and not self.bugs


@dataclass(frozen=True)
class CampaignResult:
    """The result of a campaign.

    Attributes:
        name: Name of the campaign.
        version: Of the code that has run it.
        confidence: Of the intervals.
        cells: The cells that count.
        left_out: Names of the cells that were not run, because one before is not as expected.
    """

    name: str
    version: str
    confidence: float
    cells: tuple[CellResult, ...]
    left_out: tuple[str, ...]

    @property
    def good(self) -> bool:
        """Whether every cell is good."""
        return all(cell.good for cell in self.cells)

    def as_data(self) -> dict[str, Any]:
        """Return the result as plain data."""
        return {"good": self.good, **asdict(self)}


def result_of(plan: Plan, tallies: Sequence[Tally], recordings: Path) -> CampaignResult:
    """Return the result of a campaign.

    Args:
        plan: The campaign.
        tallies: The counts of the cells that count, in the order of the plan.
        recordings: The folder of its recordings.
    """
    cells = tuple(_cell(tally, recordings) for tally in tallies)
    left_out = tuple(cell.name for cell in plan.cells[len(cells) :])
    return CampaignResult(plan.name, plan.version, plan.confidence, cells, left_out)


def _cell(tally: Tally, recordings: Path) -> CellResult:
    cell, times_s = tally.cell, tally.times_s
    found = sorted(tally.causes.values(), key=_frequent)
    found += sorted(tally.unsafe_causes.values(), key=_frequent)
    return CellResult(
        cell.name,
        cell.row,
        cell.column,
        tally.runs,
        len(cell.seeds),
        tally.passed,
        tally.held,
        tally.false,
        tally.unsafe,
        tally.bugs,
        *tally.interval,
        (min(times_s), median(times_s), max(times_s)) if times_s else (),
        tally.farthest_short_m,
        tally.deepest_m if tally.deepest_m >= 0.0 else None,
        _expected(cell.expect),
        tally.missed(),
        tuple(_cause(tally, each, recordings) for each in found),
    )


def _frequent(cause: Cause) -> tuple[int, str]:
    return -cause.count, cause.why


def _cause(tally: Tally, cause: Cause, recordings: Path) -> CauseResult:
    seed = cause.seeds[0]
    place = recordings / recording_name(tally, seed)
    return CauseResult(
        cause.verdict,
        cause.why,
        cause.count,
        tuple(cause.seeds),
        command_of(tally.cell.order, seed),
        f"{recordings.name}/{place.name}" if place.exists() else "",
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
        shares = f"{cell.least:.1%} to {cell.most:.1%}"
        times = "/".join(f"{each:.1f}" for each in cell.times_s)
        count = f"{cell.passed:,} of {cell.runs:,}"
        missed = f"  BELOW EXPECTED: {', '.join(cell.missed)}" if cell.missed else ""
        yield (
            f"{cell.name:{width}}  {count:>13} {cell.share:6.1%}  {shares:>16}"
            f"  {times + ' s' if times else '-'}{missed}"
        )
        for cause in cell.causes:
            yield from _cause_lines(cause)
    for name in result.left_out:
        yield f"{name}: not run, a cell before it is not as expected"
    runs = sum(cell.runs for cell in result.cells)
    below = sum(not cell.good for cell in result.cells)
    cells = "1 cell" if len(result.cells) == 1 else f"{len(result.cells)} cells"
    yield f"{runs:,} runs of {cells}: {f'{below} not as expected' if below else 'as expected'}"


def _cause_lines(cause: CauseResult) -> Iterator[str]:
    shown = ", ".join(map(str, cause.seeds[:_MOST_SEEDS]))
    more = ", …" if cause.count > _MOST_SEEDS else ""
    yield f"    {cause.count:5,} × {cause.verdict}: {cause.why} (seeds {shown}{more})"
    yield f"            {cause.command}"
    if cause.recording:
        yield f"            recorded in {cause.recording}"
