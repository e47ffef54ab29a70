"""Writes the file of a recording as MCAP, so that a crash costs only the latest data.

Everything since the last cut goes to the file as one chunk with a checksum, written at once and
synced to the disk. So a reader finds whole chunks, and at most one torn one at the end. The
official library makes the bytes; it never sees the file itself, so that a full disk cannot leave
it in an unknown state.
"""

from __future__ import annotations

import errno
import json
import os
import sys
from collections.abc import Mapping
from contextlib import suppress
from datetime import datetime
from io import BytesIO
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import mcap
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from pirate_sm import __version__
from pirate_sm.running.recording.format.header import CHECKPOINT, PROFILE, RUN, RunHeader
from pirate_sm.running.recording.read.mcap_content import FRAME

NS_PER_S = 1_000_000_000

Schema: TypeAlias = Mapping[str, Any] | bytes
"""A JSON Schema, or how it is written."""


class Sink(Protocol):
    """Takes the bytes of a recording."""

    def write(self, data: bytes, /) -> object:
        """Write all of the bytes."""

    def close(self) -> None:
        """Close the sink, after the last bytes."""


class DiskFile:
    """A new file whose bytes are on the disk when ``write`` returns.

    Args:
        path: Path of the file; its folder has to exist.

    Raises:
        FileExistsError: The file exists already; it does not change.
        OSError: It cannot be made.
    """

    def __init__(self, path: Path) -> None:
        if not path.parent.exists():
            raise FileNotFoundError(errno.ENOENT, f"there is no folder '{path.parent}'")
        if not path.parent.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, "its folder is a file")
        self._file = path.open("xb", buffering=0)
        self._sync_folder(path.parent)

    def write(self, data: bytes, /) -> None:
        """Write the bytes to the disk."""
        left = memoryview(data)
        while left:
            left = left[self._file.write(left) :]
        with suppress(OSError):  # some file systems and devices cannot sync
            os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _sync_folder(self, folder: Path) -> None:
        """Sync the folder, so that the file's name survives a power cut too."""
        with suppress(OSError):
            handle = os.open(folder, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


class Nowhere:
    """Discards everything, for a run that is only viewed."""

    def write(self, data: bytes, /) -> None:
        """Discard the bytes."""

    def close(self) -> None:
        """Do nothing."""


class _Gathered(BytesIO):
    """Memory that the library writes to, until :meth:`take`."""

    def __init__(self) -> None:
        super().__init__()
        self._taken = 0

    def tell(self) -> int:
        """Return the position in the file."""
        return self._taken + super().tell()

    def take(self) -> bytes:
        """Return the bytes written since the last call."""
        data = self.getvalue()
        self._taken += len(data)
        self.seek(0)
        self.truncate()
        return data


class Pieces:
    """An MCAP file being written, one piece at a time.

    Args:
        sink: Receives the bytes.
    """

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._gathered = _Gathered()
        self._index = b""
        # Only a cut ends a chunk.
        self._writer = Writer(
            self._gathered, chunk_size=sys.maxsize, compression=CompressionType.ZSTD
        )
        self._writer.start(PROFILE, f"pirate_sm {__version__} mcap {mcap.__version__}")

    def attach(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Attach a text."""
        self._writer.add_attachment(time_ns, time_ns, name, media_type, data)

    def note(self, name: str, content: Mapping[str, str]) -> None:
        """Write metadata after the last cut."""
        self._writer.add_metadata(name, dict(content))

    def topic(self, name: str, schema_name: str, schema: bytes) -> int:
        """Return the number of a new topic of JSON messages."""
        number = self._writer.register_schema(schema_name, "jsonschema", schema)
        return self._writer.register_channel(name, "json", number)

    def message(self, topic: int, time_ns: int, data: bytes) -> None:
        """Add the message to the next cut."""
        self._writer.add_message(topic, time_ns, data, time_ns)

    def cut(self) -> bytes:
        """Return everything since the last cut, up to the end of its chunk of messages.

        What is after the chunk, its index, comes with the next piece. So a piece of which the end
        could not be written has no whole chunk, and what is said to be recorded is what is read.
        """
        self._writer.flush()  # type: ignore[no-untyped-call]
        data = self._index + self._gathered.take()
        end = _end_of_chunk(data)
        self._index = data[end:]
        return data[:end]

    def write(self, data: bytes) -> None:
        """Write pieces to the file, in the order of their cuts.

        Raises:
            OSError: They could not be written; some may be.
        """
        if data:
            self._sink.write(data)

    def finish(self) -> None:
        """Complete the file with the index that readers look for at the end.

        Raises:
            OSError: The index could not be written.
        """
        self._writer.finish()  # type: ignore[no-untyped-call]
        self.write(self._index + self._gathered.take())

    def close(self) -> None:
        """Close the sink; write no more."""
        self._sink.close()


def _end_of_chunk(data: bytes) -> int:
    """Return where the chunk ends in these bytes of a file; 0 if there is none."""
    at = len(MCAP0_MAGIC) if data.startswith(MCAP0_MAGIC) else 0
    while at < len(data):
        opcode, length = FRAME.unpack_from(data, at)
        at += FRAME.size + int(length)
        if opcode == Opcode.CHUNK:
            return at
    return 0


class RecordingFile(Pieces):
    """A recording being written; its header is on disk from the start.

    Args:
        sink: Receives the bytes.
        header: The header.

    Raises:
        OSError: The header cannot be written.
    """

    def __init__(self, sink: Sink, header: RunHeader) -> None:
        super().__init__(sink)
        self._topics: dict[str, int] = {}
        self._marked = False
        self._start_s: float | None = None
        self._zero_ns = round(datetime.fromisoformat(header.began).timestamp() * NS_PER_S)
        self.attach(RUN, "application/json", _json(header.to_json()), self._zero_ns)
        for file in header.files:
            self.attach(file.attachment, "application/yaml", file.text.encode(), self._zero_ns)
        self.write(self._gathered.take())

    def mark(self) -> None:
        """Mark the next piece as one with a checkpoint, for readers that begin at the end."""
        self._marked = True

    def cut(self) -> bytes:
        """Return everything since the last cut, after a mark if it has a checkpoint."""
        if self._marked:
            self._marked = False
            names = {str(number): name for name, number in self._topics.items()}
            at = str(self._gathered.tell())
            self.note(CHECKPOINT, {"at": at, "topics": json.dumps(names)})
        return super().cut()

    def time_ns(self, at_s: float) -> int:
        """Return the time of a mission time, ns since 1970; the first call sets the beginning."""
        if self._start_s is None:
            self._start_s = at_s
        return self._zero_ns + round((at_s - self._start_s) * NS_PER_S)

    def add(self, topic: str, at_s: float, data: bytes, schema: Schema, schema_name: str) -> None:
        """Add the message to the next cut.

        Args:
            topic: Its topic.
            at_s: Mission time.
            data: The message, JSON.
            schema: JSON Schema of the topic; used when the topic comes first.
            schema_name: Name of the schema.
        """
        self.add_at(topic, self.time_ns(at_s), data, schema, schema_name)

    def add_at(
        self, topic: str, time_ns: int, data: bytes, schema: Schema, schema_name: str
    ) -> None:
        """Add the message to the next cut, with its time in ns since 1970; see :meth:`add`."""
        number = self._topics.get(topic)
        if number is None:
            written = schema if isinstance(schema, bytes) else _json(schema)
            number = self._topics[topic] = self.topic(topic, schema_name, written)
        self.message(number, time_ns, data)


def _json(data: Mapping[str, Any]) -> bytes:
    return json.dumps(data, allow_nan=False).encode()
