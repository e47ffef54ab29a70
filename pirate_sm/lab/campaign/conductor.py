"""Runs a campaign: gives chunks to the crew and stores what comes back, until it is enough.

Runs that failed are repeated with a recording, so that they can be looked at.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from itertools import groupby, islice
from math import inf
from operator import attrgetter
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import is_there
from pirate_sm.lab.campaign.chunk import (
    CHUNK,
    Chunk,
    OtherVersionError,
    RunRow,
    Sent,
    cut,
    loaded_mission,
)
from pirate_sm.lab.campaign.crew import ChunkRunner, DaskCrew
from pirate_sm.lab.campaign.margins import CellMargins, margins_of, wanted_cells
from pirate_sm.lab.campaign.plan import FORMAT, CampaignPlan, Cell, code_version, plan_of, varied
from pirate_sm.lab.campaign.store import DamagedMarkError, Store
from pirate_sm.lab.campaign.tally import Tally
from pirate_sm.lab.campaign.watched_run import finished
from pirate_sm.running.wiring import prepare

_TESTED_CHUNK = 4
"""Runs of a chunk where a test may end the cell after any of them: fewer run in vain [decided]."""

_LOOK_S = 0.5
"""So often progress is shown when nothing comes."""


class Progress(NamedTuple):
    """How far a campaign is.

    Attributes:
        done: Runs that have results, though some may not count yet.
        of: Runs in all, if no cell ends earlier.
    """

    done: int
    of: int

    def words(self, done_before: int, took_s: float) -> str:
        """Return it for people, with the pace as soon as there is one.

        Args:
            done_before: How many runs had results when this process began.
            took_s: How long it has been running.
        """
        new = self.done - done_before
        pace = f"{new / max(took_s, 1e-3) * 3600:,.0f} per hour" if new else "none new yet"
        return f" ({self.done:,} of {self.of:,} runs, {pace})"


class Stored(NamedTuple):
    """What is in a folder of results.

    Attributes:
        plan: The campaign, without its missions.
        tallies: The counts of its cells that count.
        damaged: What is wrong with files of results that cannot be read, and what to do.
        margins: How far they hold, by their keys, if that was asked.
    """

    plan: CampaignPlan
    tallies: list[Tally]
    damaged: tuple[str, ...]
    margins: Mapping[str, CellMargins]


def stored_plan(store: Store) -> CampaignPlan:
    """Return the plan of the campaign whose results are in a store.

    Raises:
        UsageError: There are none, or another version of the format.
        DamagedMarkError: The description of the campaign is damaged.
    """
    mark = store.mark()
    version, name = mark.get("format"), mark.get("campaign")
    if version is None:
        raise DamagedMarkError(store.folder, "`format` is missing", name)
    if version != FORMAT:
        raise UsageError(
            f"the results in '{store.folder}' have format {version!r}, and this version reads "
            f"{FORMAT}: use the version of this program that wrote them"
        )
    try:
        return plan_of(mark)
    except ValueError as error:
        raise DamagedMarkError(store.folder, str(error), name) from None


def stored(folder: Path) -> Stored:
    """Return the campaign whose results are in a folder, with its counts.

    Raises:
        UsageError: There are none, or this version cannot read them.
    """
    store = Store(folder)
    plan = stored_plan(store)
    conductor = Conductor(plan, store)
    todo = (
        "its runs do not count; the campaign's command with --resume repeats those that are missing"
    )
    damaged = tuple(f"'{file}' is damaged ({why}): {todo}" for file, why in store.damaged.items())
    return Stored(plan, conductor.results, damaged, conductor.margins)


class Conductor:
    """The course of a campaign.

    Args:
        plan: The campaign.
        store: Where results are kept; what is in it already is not run again.

    Attributes:
        tallies: The counts of each cell, in the order of the plan.
        levels: Of cells round these, which are chosen one after another, by what is known so far.
    """

    def __init__(self, plan: CampaignPlan, store: Store) -> None:
        self._plan = plan
        self._store = store
        self.tallies = [self._tally(cell) for cell in plan.cells]
        self.levels: list[Tally] = []
        self._by_key = {each.cell.key: each for each in self.tallies}
        self._begun = dict.fromkeys(self._by_key, 0)
        self._unasked: dict[str, list[RunRow]] = defaultdict(list)
        for rows in store.read():
            self._count(rows)
        self._choose()

    @property
    def results(self) -> list[Tally]:
        """The cells that count: all, or those up to the first that is not as expected."""
        if self._plan.stop.violated:
            for number, tally in enumerate(self.tallies):
                if tally.decided and tally.violated:
                    return self.tallies[: number + 1]
        return self.tallies

    @property
    def margins(self) -> Mapping[str, CellMargins]:
        """How far the cells hold, by their keys, as far as that is known; empty if not asked."""
        wanted = self._plan.margins
        if wanted is None:
            return {}
        return {each.key: margins_of(each, wanted, self._by_key.get) for each in self._plan.cells}

    @property
    def goes_on(self) -> bool:
        """Whether more runs are needed."""
        return not all(each.decided for each in self._all)

    @property
    def _open(self) -> int:
        return sum(not each.decided for each in self._all)

    @property
    def _all(self) -> list[Tally]:
        return [*self.results, *self.levels]

    def _tally(self, cell: Cell) -> Tally:
        return Tally(cell, self._plan.confidence, self._plan.stop, self._plan.test)

    def _choose(self) -> None:
        """Add the cells whose results are needed next, if margins are asked."""
        margins = self._plan.margins
        if margins is None:
            return
        for around in self._plan.cells:
            while new := [
                cell
                for cell in wanted_cells(around, margins, self._by_key.get)
                if cell.key not in self._by_key
            ]:
                for cell in new:
                    tally = self._by_key[cell.key] = self._tally(cell)
                    self._begun[cell.key] = 0
                    self._store.describe(cell.key, cell.values)
                    tally.add(self._unasked.pop(cell.key, ()))
                    self.levels.append(tally)

    @property
    def progress(self) -> Progress:
        """How many runs are done, and of how many."""
        ends = [each.runs if each.decided else len(each.cell.seeds) for each in self._all]
        return Progress(sum(each.done for each in self._all), sum(ends))

    def conduct(
        self, crew: ChunkRunner, show: Callable[[Progress], None] = lambda progress: None
    ) -> None:
        """Run what has no result yet, until every cell has had enough runs.

        Args:
            crew: Runs the chunks.
            show: Takes the progress.

        Raises:
            BackendError: The workers are lost; results so far are stored.
            UsageError: Results cannot be stored, or workers cannot be used.
        """
        while self.goes_on:
            for _ in range(crew.room):
                chunk = self._next()
                if chunk is None:
                    break
                crew.submit(chunk)
            open_before = self._open
            for done in crew.wait(_LOOK_S):
                self._store.add(done.rows)
                self._count(done.rows)
                left = done.chunk.seeds[len(done.rows) :]
                if left and not self._by_key[done.chunk.cell].decided:
                    crew.submit(cut(done.chunk, left))
            if self._open < open_before:
                self._choose()
            show(self.progress)

    def _count(self, rows: Iterable[RunRow]) -> None:
        """Count the rows of known cells; of others keep them, as they may be asked for yet."""
        for key, mine in groupby(rows, key=attrgetter("cell")):
            if key in self._by_key:
                self._by_key[key].add(mine)
            elif self._plan.margins is not None:
                self._unasked[key] += mine

    def _next(self) -> Chunk | None:
        """Return a chunk of the undecided cell that was given least so far; None if there is none.

        So the chunks of a cell that may end early are not run far ahead.
        """
        open_ = [each for each in self._all if not each.decided]
        most = CHUNK if self._plan.test is None else _TESTED_CHUNK
        for tally in sorted(open_, key=lambda each: self._begun[each.cell.key] - each.runs):
            cell = tally.cell
            positions = list(islice(tally.missing(self._begun[cell.key]), most))
            if positions:
                self._begun[cell.key] = positions[-1] + 1
                return chunk_of(cell, [cell.seeds[position] for position in positions])
        return None


def chunk_of(cell: Cell, seeds: Iterable[int]) -> Chunk:
    """Return the chunk with some seeds of a cell."""
    runs, design = tuple(seeds), cell.design
    orders = {run: varied(cell, run, design.drawn(run)) for run in runs} if design else {}
    return Chunk(cell.key, cell.order, cell.end, cell.mission, runs, orders)


# --- runs that are recorded ----------------------------------------------------------------------


Which: TypeAlias = Literal["first", "all", "none"]

_MOST_CAUSES = 10
"""The most causes of a cell that are recorded."""

_LONGEST = 80


class Recorded(NamedTuple):
    """A run that was recorded; no content if that was not possible."""

    cell: str
    seed: int
    content: bytes


def record_chunk(chunk: Chunk, sent: Sent, version: str) -> list[Recorded]:
    """Run a chunk on this worker with recordings; return them.

    Raises:
        OtherVersionError: This worker's code is another one.
    """
    if version != code_version():
        raise OtherVersionError(code_version())
    return [_recorded(chunk, sent, seed) for seed in chunk.seeds]


def _recorded(chunk: Chunk, sent: Sent, seed: int) -> Recorded:
    from pirate_sm.running.wiring.run_recorder import RunRecorder, new_recording, run_header

    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        with suppress(Exception):  # it was an outcome already, and is none of the recording
            prepared = prepare(chunk.order_of(seed), loaded_mission(sent))
            header = run_header(prepared, inf, datetime.now(UTC).astimezone())
            recording = RunRecorder(prepared, header, new_recording(path, header))
            try:
                finished(
                    prepared,
                    perf_counter(),
                    slides=False,
                    tap=recording.recorder,
                    begun=lambda run: recording.follow(prepared, lambda: run.state),
                )
            finally:
                recording.close(path)
        return Recorded(chunk.cell, seed, path.read_bytes() if is_there(path) else b"")


def recording_name(tally: Tally, seed: int) -> str:
    """Return the file name of the recording of a run."""
    name = re.sub(r"[^\w.+-]+", "_", tally.cell.name).strip("_")[:_LONGEST]
    return f"{name}_{tally.cell.key[:6]}_{seed}.mcap"


def seeds_to_record(tally: Tally, which: Which) -> Sequence[int]:
    """Return the seeds of a cell that are to be recorded.

    Args:
        tally: The results of the cell.
        which: The first seed of each cause, or all seeds that are kept of it.
    """
    causes = [*tally.causes.values(), *tally.unsafe_causes.values()]
    causes.sort(key=lambda each: -each.count)
    most = {"first": 1, "all": None, "none": 0}[which]
    return sorted({seed for cause in causes[:_MOST_CAUSES] for seed in cause.seeds[:most]})


# --- recordings of failures ----------------------------------------------------------------------


def failures(tallies: Sequence[Tally], store: Store, which: Which) -> list[Chunk]:
    """Return the runs that are to be repeated with a recording and have none yet."""
    return [
        chunk_of(tally.cell, [seed])
        for tally in tallies
        for seed in seeds_to_record(tally, which)
        if not is_there(store.recordings / recording_name(tally, seed))
    ]


def record_failures(tallies: Sequence[Tally], store: Store, crew: DaskCrew, which: Which) -> None:
    """Have workers repeat runs that failed, and keep the recordings they send.

    Raises:
        BackendError: The workers are lost.
        UsageError: A recording cannot be written.
    """
    by_key = {each.cell.key: each for each in tallies}
    left, under_way = failures(tallies, store, which), 0
    crew = crew.doing(record_chunk)
    while left or under_way:
        while left and crew.room > 0:
            crew.submit(left.pop(0))
            under_way += 1
        for done in crew.wait(_LOOK_S):
            under_way -= 1
            for each in done.rows:
                if isinstance(each, Recorded) and each.content:
                    store.keep(recording_name(by_key[each.cell], each.seed), each.content)
