"""Reads the pieces of a recording's file, one at a time and in any order."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from pirate_sm.core.on_disk import opened
from pirate_sm.running.recording.read.mcap_content import index_of
from pirate_sm.running.recording.read.mcap_records import (
    ChunkPlace,
    DamagedError,
    FileTopics,
    RawMessage,
    messages_in,
    records_of,
)


class Chunks:
    """Reads pieces of a file.

    Args:
        path: The file.
        pieces: The places of the pieces.
        topics: Names of topics that are known already, by their numbers.

    Attributes:
        topics: The topics read so far.
    """

    def __init__(
        self, path: Path, pieces: list[ChunkPlace], topics: Mapping[int, str] | None = None
    ) -> None:
        self.topics = FileTopics()
        self.topics.names.update(topics or {})
        self._path = path
        self._pieces = pieces
        self._learned = 0

    def entries(self, place: int) -> list[RawMessage]:
        """Return the messages of a piece in the order of writing, and remember their topics.

        Args:
            place: Number of the piece.

        Raises:
            DamagedError: The piece is damaged.
            OSError: The file cannot be read.
        """
        records = self._records(place)
        self.topics.learn(records)
        found = list(messages_in(records))
        missing = {each.number for each in found} - self.topics.names.keys()
        if missing and not self._learned:  # reading began in the middle, or after damage
            with opened(self._path) as file:
                self.topics.learn(index_of(file))
        while (missing := missing - self.topics.names.keys()) and self._learned < place:
            with suppress(DamagedError):
                self.topics.learn(self._records(self._learned))
            self._learned += 1
        if missing:
            raise DamagedError(f"channel {min(missing)} is unknown")
        return found

    def _records(self, place: int) -> bytes:
        with opened(self._path) as file:
            return records_of(file, self._pieces[place])
