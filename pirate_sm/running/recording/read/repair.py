"""Repairs a recording that was cut short: adds the end and the index that other programs need.

Every piece that is whole by its own checksum is copied to a new file in the order of writing. Where
a damaged one was between them, the new file has a gap, and says so in its metadata.
"""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from pirate_sm.core.errors import RecordingError
from pirate_sm.core.on_disk import opened
from pirate_sm.running.recording.format.engine_topics import STATE, UNLOGGED, Topics
from pirate_sm.running.recording.format.header import REPAIRED
from pirate_sm.running.recording.read.mcap_content import Chunks, index_of
from pirate_sm.running.recording.read.pieces import DamagedInsideError, Gap, RecordedStep
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.write.recording_file import DiskFile, Pieces

_LEAST_BYTES = 1 << 20
"""The least size of the messages in one piece, bytes; small pieces only help during a run."""


class Repaired(NamedTuple):
    """The content of a repaired recording, and what it lacks.

    Attributes:
        steps: Number of steps.
        until_s: Time of its end.
        torn_bytes: Bytes at the end of the old file that are cut off or follow damage.
        damage: Why more was left out; empty if nothing was.
        gaps: Where damaged steps are left out, with times since the run began.
        complete: Whether it contains all that was recorded.
    """

    steps: int = 0
    until_s: float = 0.0
    torn_bytes: int = 0
    damage: str = ""
    gaps: tuple[Gap, ...] = ()
    complete: bool = False


def is_whole(recording: Recording) -> bool:
    """Return whether the recording is undamaged and has its index."""
    if not recording.content.indexed:
        return False
    try:
        for _ in recording.commits():
            pass
    except RecordingError:
        return False
    return True


def repair(recording: Recording, path: Path) -> Repaired:
    """Write all that is whole to a new, complete file.

    Args:
        recording: The recording to repair; its file does not change.
        path: The new file.

    Raises:
        FileExistsError: The new file exists already; it does not change.
        OSError: It cannot be written; no file is left then.
    """
    with closing(DiskFile(path)) as sink:
        try:
            return _write(recording, Pieces(sink))
        except BaseException:
            path.unlink()
            raise


def _write(recording: Recording, file: Pieces) -> Repaired:
    content, copy = recording.content, _Copy(recording, file)
    for each in content.attachments.values():
        file.attach(each.name, each.media_type, each.data, each.log_time)
    damages = [content.damage] if content.damage else []
    for place in range(len(content.pieces)):
        try:
            copy.take(place, recording.steps_in(place))
        except DamagedInsideError as error:
            copy.lost_end = True
            damages.insert(-1 if content.damage else len(damages), error.how)
    file.write(file.cut())
    torn_bytes = content.size - content.whole
    damage = " and ".join(dict.fromkeys(damages))
    gaps = (*recording.gaps, *copy.gaps)
    complete = recording.complete and not damage and not gaps
    if not complete:
        lost_end = copy.lost_end or recording.lost_end or content.damage
        said = {"until_s": repr(copy.until_s), "torn_bytes": str(torn_bytes), "damage": damage}
        end = "damaged" if lost_end else ""
        file.note(REPAIRED, {**said, "gaps": json.dumps(gaps), "end": end})
    file.finish()
    until_s = copy.until_s - recording.origin_s if copy.steps else 0.0
    return Repaired(copy.steps, until_s, torn_bytes, damage, gaps, complete)


class _Copy:
    """Copies piece after piece to the new file."""

    def __init__(self, recording: Recording, file: Pieces) -> None:
        self.steps, self.until_s, self._origin_s = 0, 0.0, recording.origin_s
        self.gaps: list[Gap] = []
        self.lost_end = False  # whether damage has come since the last steps
        self._next = 0
        self._known = {gap.step for gap in recording.gaps}
        content = recording.content
        self._chunks = Chunks(recording.path, content.pieces, content.topics)
        with opened(recording.path) as old:
            self._chunks.topics.learn(index_of(old))
        known = Topics(recording.header.layout).by_name
        self._ours = {**known, STATE.name: STATE, UNLOGGED.name: UNLOGGED}
        self._file = file
        self._topics: dict[int, int] = {}
        self._uncut = 0

    def take(self, place: int, steps: list[RecordedStep]) -> None:
        """Copy this piece with these steps to the new file."""
        file, topics = self._file, self._topics
        if steps:
            self._follow(steps)
            self.lost_end = False
        for number, time_ns, data in self._chunks.entries(place):
            if number not in topics:
                topics[number] = file.topic(*self._described(number))
            file.message(topics[number], time_ns, data)
            self._uncut += len(data)
        if self._uncut >= _LEAST_BYTES:
            file.write(file.cut())
            self._uncut = 0
        self.steps += len(steps)
        self.until_s = steps[-1].at_s if steps else self.until_s

    def _described(self, number: int) -> tuple[str, str, bytes]:
        """Return a topic, the name of its schema and the schema; empty if that is not known."""
        name, schema_name, schema = self._chunks.topics.described(number)
        ours = None if schema else self._ours.get(name)
        return (name, ours.schema_name, ours.schema_json) if ours else (name, schema_name, schema)

    def _follow(self, steps: list[RecordedStep]) -> None:
        """Note a gap if these steps are not the next ones; a piece of the file begins there."""
        first = steps[0]
        if first.number != self._next:
            self._file.write(self._file.cut())
            self._uncut = 0
            if first.number not in self._known:
                before_s = self.until_s - self._origin_s if self.steps else 0.0
                self.gaps.append(Gap(first.number, before_s, first.at_s - self._origin_s))
        self._next = steps[-1].number + 1
