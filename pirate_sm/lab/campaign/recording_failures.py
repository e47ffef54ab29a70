"""Has runs that failed repeated with a recording, and keeps the recordings with the results."""

from __future__ import annotations

from collections.abc import Sequence

from pirate_sm.core.on_disk import is_there
from pirate_sm.lab.campaign.chunk import Chunk
from pirate_sm.lab.campaign.conductor import chunk_of
from pirate_sm.lab.campaign.crew import DaskCrew
from pirate_sm.lab.campaign.recorded_run import (
    Recorded,
    Which,
    record_chunk,
    recording_name,
    seeds_to_record,
)
from pirate_sm.lab.campaign.store import Store
from pirate_sm.lab.campaign.tally import Tally

_LOOK_S = 0.5


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
