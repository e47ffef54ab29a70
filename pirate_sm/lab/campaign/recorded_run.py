"""Runs that failed, once more with a recording, so that they can be looked at."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core.on_disk import is_there
from pirate_sm.lab.campaign.chunk import Chunk, OtherVersionError, Sent, loaded_mission
from pirate_sm.lab.campaign.code_version import code_version
from pirate_sm.lab.campaign.tally import Tally
from pirate_sm.lab.campaign.watched_run import finished
from pirate_sm.running.wiring import prepare

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
            prepared = prepare(replace(chunk.order, seed=seed), loaded_mission(sent))
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
