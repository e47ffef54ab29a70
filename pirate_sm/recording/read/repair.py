"""Repairs a recording that was cut short: adds the end and the index that other programs need.

Everything that is whole is copied to a new file in the order of writing. Steps after a missing one
could not be replayed, so everything after damage is left out.
"""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from pirate_sm.errors import RecordingError
from pirate_sm.recording.format.header import REPAIRED
from pirate_sm.recording.read.chunks import Chunks
from pirate_sm.recording.read.header_reader import DamagedInsideError
from pirate_sm.recording.read.reader import Recording
from pirate_sm.recording.read.steps import Step
from pirate_sm.recording.write.recording_file import DiskFile, Pieces

_LEAST_BYTES = 1 << 20
"""The least size of the messages in one piece, bytes; small pieces only help during a run."""


class Repaired(NamedTuple):
    """The content of a repaired recording, and what it lacks.

    Attributes:
        steps: Number of steps.
        until_s: Time of its end.
        torn_bytes: Bytes at the end of the old file that are cut off or follow damage.
        damage: Why more was left out; empty if nothing was.
        left_until_s: Approximate time of the end of what was left out; 0 if unknown.
        complete: Whether it contains all that was recorded.
    """

    steps: int = 0
    until_s: float = 0.0
    torn_bytes: int = 0
    damage: str = ""
    left_until_s: float = 0.0
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
    damage, left_until_s = content.damage, 0.0
    try:
        for place, steps in enumerate(recording.commits()):
            copy.take(place, steps)
    except DamagedInsideError as error:
        damage, left_until_s = error.how, max(recording.starts_s)
    file.write(file.cut())
    torn_bytes = content.size - content.whole
    complete = recording.complete and not damage
    if not complete:
        said = {"until_s": repr(copy.until_s), "torn_bytes": str(torn_bytes), "damage": damage}
        file.note(REPAIRED, said)
    file.finish()
    until_s = copy.until_s - recording.origin_s if copy.steps else 0.0
    return Repaired(copy.steps, until_s, torn_bytes, damage, left_until_s, complete)


class _Copy:
    """Copies piece after piece to the new file."""

    def __init__(self, recording: Recording, file: Pieces) -> None:
        self.steps, self.until_s = 0, 0.0
        self._chunks = Chunks(recording.path, recording.content.pieces)
        self._file = file
        self._topics: dict[int, int] = {}
        self._uncut = 0

    def take(self, place: int, steps: list[Step]) -> None:
        """Copy this piece with these steps to the new file."""
        file, topics = self._file, self._topics
        for number, time_ns, data in self._chunks.entries(place):
            if number not in topics:
                topics[number] = file.topic(*self._chunks.topics.described(number))
            file.message(topics[number], time_ns, data)
            self._uncut += len(data)
        if self._uncut >= _LEAST_BYTES:
            file.write(file.cut())
            self._uncut = 0
        self.steps += len(steps)
        self.until_s = steps[-1].at_s if steps else self.until_s
