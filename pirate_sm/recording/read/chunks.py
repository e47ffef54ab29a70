"""Reads the pieces of a recording's file, one at a time and in any order."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pirate_sm.on_disk import opened
from pirate_sm.recording.read.mcap_records import (
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
        while missing and self._learned < place:  # reading began in the middle
            self.topics.learn(self._records(self._learned))
            self._learned += 1
            missing -= self.topics.names.keys()
        if missing:
            raise DamagedError(f"channel {min(missing)} is unknown")
        return found

    def _records(self, place: int) -> bytes:
        with opened(self._path) as file:
            return records_of(file, self._pieces[place])
