"""Finds the content of an MCAP file that is whole, cut short, or damaged, chunk by chunk.

The official reader stops with one of many exceptions if a file ends early. This module first finds
the records by their lengths, to distinguish records that are cut off from damaged ones. One chunk
is in memory at a time.
"""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import BinaryIO, Final, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Metadata, Schema
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

from pirate_sm.core.on_disk import opened
from pirate_sm.running.recording.format.header import CHECKPOINT

# --- records --------------------------------------------------------------------------------------


LARGEST_CHUNK: Final = 1 << 28
"""The largest chunk or text that is read, bytes. Ours are far smaller, and damage can claim any
size."""

FRAME: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<HIQQ")
BROKEN: Final = (
    *(McapError, CRCValidationError, ValueError, OverflowError),
    *(struct.error, zstandard.ZstdError),
)
"""The exceptions that reading a damaged record can raise."""


class DamagedError(Exception):
    """Is raised for damaged bytes."""


class RecordPlace(NamedTuple):
    """A record's place in the file or in a chunk."""

    opcode: int
    start: int
    end: int


class ChunkPlace(NamedTuple):
    """A chunk in the file.

    Attributes:
        at: Offset of its content, bytes; ``size`` is the length of the content.
        start_ns: Time of its first message.
    """

    at: int
    size: int
    start_ns: int


class RawMessage(NamedTuple):
    """A message.

    Attributes:
        number: Number of its topic, see :class:`FileTopics`.
        time_ns: Time, ns since 1970.
        data: Its content.
    """

    number: int
    time_ns: int
    data: bytes


def records_of(file: BinaryIO, piece: ChunkPlace) -> bytes:
    """Return the records of a chunk.

    Raises:
        DamagedError: The chunk is damaged.
        OSError: The chunk cannot be read.
    """
    try:
        chunk: Chunk = Chunk.read(stream_of(bytes_at(file, piece.at, piece.size)))
        size = chunk.uncompressed_size
        if chunk.compression == "zstd":
            size = max(size, zstandard.frame_content_size(chunk.data))
        if size > LARGEST_CHUNK:
            raise ValueError("the chunk is larger than any of this program")
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
        records: bytes = stream.read(length)
    except BROKEN:
        raise DamagedError(f"at byte {piece.at}") from None
    return records


class FileTopics:
    """The topics of a file by their numbers, which never change."""

    def __init__(self) -> None:
        self.names: dict[int, str] = {}
        self.channels: dict[int, Channel] = {}
        self.schemas: dict[int, Schema] = {}

    def learn(self, records: bytes) -> None:
        """Remember the topics that are introduced in this chunk."""
        for opcode, start, end in _inside(records):
            if opcode == Opcode.CHANNEL:
                channel: Channel = Channel.read(stream_of(records[start:end]))
                self.channels[channel.id] = channel
                self.names[channel.id] = channel.topic
            elif opcode == Opcode.SCHEMA:
                schema: Schema = Schema.read(stream_of(records[start:end]))
                self.schemas[schema.id] = schema

    def described(self, number: int) -> tuple[str, str, bytes]:
        """Return a topic, the name of its schema and the schema; empty without a schema."""
        name, channel = self.names[number], self.channels.get(number)
        schema = self.schemas.get(channel.schema_id) if channel else None
        return (name, schema.name, schema.data) if schema else (name, "", b"")


def messages_in(records: bytes) -> Iterator[RawMessage]:
    """Yield the messages of a chunk, in the order of writing."""
    for opcode, start, end in _inside(records):
        if opcode == Opcode.MESSAGE:
            number, _, time_ns, _ = _MESSAGE.unpack_from(records, start)
            yield RawMessage(number, time_ns, records[start + _MESSAGE.size : end])


def _inside(records: bytes) -> Iterator[RecordPlace]:
    """Yield the places of the records in a chunk.

    Raises:
        DamagedError: A record goes beyond the end of the chunk.
    """
    at, size = 0, len(records)
    while at + FRAME.size <= size:
        opcode, length = FRAME.unpack_from(records, at)
        start, at = at + FRAME.size, at + FRAME.size + length
        if at > size or (opcode == Opcode.MESSAGE and length < _MESSAGE.size):
            raise DamagedError("a chunk holds something else than records")
        yield RecordPlace(opcode, start, at)


def bytes_at(file: BinaryIO, at: int, size: int) -> bytes:
    """Return bytes at a place in the file; raise ``ValueError`` for more than a chunk."""
    if size > LARGEST_CHUNK:
        raise ValueError("it is larger than any of this program")
    file.seek(at)
    return file.read(size)


def stream_of(data: bytes) -> ReadDataStream:
    """Return the bytes as a stream for the official library."""
    return ReadDataStream(BytesIO(data))


# --- content --------------------------------------------------------------------------------------


_SEARCHED_BYTES: Final = 1 << 20
"""How much of a file is searched at once for the last checkpoint, bytes."""

_TIME: Final = struct.Struct("<Q")
_CRC: Final = struct.Struct("<I")
_FOOTER: Final = struct.Struct("<BQQQI")


class NotMcapError(Exception):
    """Is raised for a file that is not MCAP."""


class Content(NamedTuple):
    """The content of a file.

    Attributes:
        profile: The profile in the MCAP header; None without a header.
        attachments: By name.
        metadata: By name.
        pieces: The chunks. Damage within one is found when it is read.
        complete: Whether all data is there; only the index follows it.
        indexed: Whether the index is there too, undamaged.
        damage: Where the damage begins; empty if there is none.
        whole: Bytes of whole records; the rest is torn.
        size: Size of the file, bytes.
        since: What is between the first chunk and this byte was left out; 0: nothing.
    """

    profile: str | None
    attachments: dict[str, Attachment]
    metadata: dict[str, dict[str, str]]
    pieces: list[ChunkPlace]
    complete: bool
    whole: int
    size: int
    indexed: bool = False
    damage: str = ""
    since: int = 0

    @property
    def topics(self) -> dict[int, str]:
        """Names of the topics that the last mark before a checkpoint tells, by their numbers."""
        try:
            found = json.loads(self.metadata.get(CHECKPOINT, {}).get("topics", "{}"))
            return {int(number): str(name) for number, name in found.items()}
        except (ValueError, AttributeError):
            return {}


def read_content(file: BinaryIO, since: int = 0) -> Content:
    """Return the content of the file up to its end, or to where it is cut off or damaged.

    Args:
        file: The file.
        since: Leave out what is between the first chunk and this byte, where a record begins.

    Raises:
        NotMcapError: The file is not MCAP.
        OSError: The file cannot be read.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    if not MCAP0_MAGIC.startswith(file.read(len(MCAP0_MAGIC))):
        raise NotMcapError
    content, bad, good, end = (
        Content(None, {}, {}, [], False, 0, size, since=since),
        [],
        0,
        len(MCAP0_MAGIC),
    )
    for frame in chain(_first(file, size, since), _frames(file, size, since)):
        end = frame.end
        try:
            if frame.opcode == Opcode.CHUNK:
                content.pieces.append(_piece(file, frame))
            elif frame.opcode in _READ:
                content = _READ[frame.opcode](content, _small(file, frame))
                good = frame.start
        except BROKEN:
            bad.append(frame.start)
        if frame.opcode == Opcode.DATA_END:
            content = content._replace(complete=True)
    broken = not content.complete and size > len(MCAP0_MAGIC) and _ends_whole(file, size)
    if not content.complete:
        bad += _torn(file, content.pieces)
    good = max(good, content.pieces[-1].at if content.pieces else 0)
    if broken or (bad and (content.complete or min(bad) < good)):
        return _up_to(content, min([*bad, end]))
    whole = size if content.complete else min([*(at - FRAME.size for at in bad), end])
    return content._replace(whole=whole, indexed=content.complete and index_of(file) != b"")


def _up_to(content: Content, at: int) -> Content:
    """Return the content before the damage at this byte."""
    pieces = [piece for piece in content.pieces if piece.at + piece.size <= at]
    whole = pieces[-1].at + pieces[-1].size if pieces else min(at, content.size)
    return content._replace(pieces=pieces, complete=False, whole=whole, damage=f"at byte {at}")


def newest_checkpoints(file: BinaryIO) -> Iterator[int]:
    """Yield where the marks before pieces with a checkpoint begin, the last one first.

    The file is searched from its end. A mark holds its own offset, so nothing else is taken for it.
    """
    name, before = CHECKPOINT.encode(), FRAME.size + 4  # the length of the name
    end = file.seek(0, os.SEEK_END)
    while end > 0:
        begin = max(0, end - _SEARCHED_BYTES)
        data = bytes_at(file, begin, end - begin)
        at = data.rfind(name)
        while at >= 0:
            start = begin + at - before
            if start > 0 and _is_mark(file, start):
                yield start
            at = data.rfind(name, 0, at)
        end = begin + len(name) - 1 if begin else 0


def _is_mark(file: BinaryIO, start: int) -> bool:
    opcode, length = FRAME.unpack(bytes_at(file, start, FRAME.size))
    if opcode != Opcode.METADATA or length > _SEARCHED_BYTES:
        return False
    try:
        mark: Metadata = Metadata.read(stream_of(bytes_at(file, start + FRAME.size, length)))
    except BROKEN:
        return False
    return bool(mark.metadata.get("at") == str(start))


def _first(file: BinaryIO, size: int, since: int) -> Iterator[RecordPlace]:
    """Yield the records up to the first chunk, which are before this byte."""
    for frame in _frames(file, size) if since else ():
        if frame.end > since:
            return
        yield frame
        if frame.opcode == Opcode.CHUNK:
            return


def _frames(file: BinaryIO, size: int, since: int = 0) -> Iterator[RecordPlace]:
    """Yield the places of the whole records from this byte on, by their lengths."""
    at = since or len(MCAP0_MAGIC)
    while at + FRAME.size <= size:
        file.seek(at)
        opcode, length = FRAME.unpack(file.read(FRAME.size))
        start, end = at + FRAME.size, at + FRAME.size + length
        if opcode == 0 or end > size:
            return
        yield RecordPlace(opcode, start, end)
        if opcode == Opcode.DATA_END:
            return
        at = end


def index_of(file: BinaryIO) -> bytes:
    """Return the index at the end of the file; empty if there is none, or it is damaged."""
    size = file.seek(0, os.SEEK_END)
    at = size - _FOOTER.size - len(MCAP0_MAGIC)
    if at < 0 or not _ends_whole(file, size):
        return b""
    footer = bytes_at(file, at, _FOOTER.size)
    opcode, length, begins, _, crc = _FOOTER.unpack(footer)
    if (opcode, length) != (Opcode.FOOTER, _FOOTER.size - FRAME.size) or not 0 < begins <= at:
        return b""
    try:
        index = bytes_at(file, begins, at - begins)
    except ValueError:
        return b""
    return index if zlib.crc32(footer[: -_CRC.size], zlib.crc32(index)) == crc else b""


def _ends_whole(file: BinaryIO, size: int) -> bool:
    return bytes_at(file, size - len(MCAP0_MAGIC), len(MCAP0_MAGIC)) == MCAP0_MAGIC


def _torn(file: BinaryIO, pieces: list[ChunkPlace]) -> Iterator[int]:
    """Remove the chunks whose writing was cut short, and yield where each of them begins."""
    while pieces:
        try:
            records_of(file, pieces[-1])
        except DamagedError:
            yield pieces.pop().at
        else:
            return


def _piece(file: BinaryIO, frame: RecordPlace) -> ChunkPlace:
    (start_ns,) = _TIME.unpack(
        bytes_at(file, frame.start, min(_TIME.size, frame.end - frame.start))
    )
    return ChunkPlace(frame.start, frame.end - frame.start, start_ns)


def _small(file: BinaryIO, frame: RecordPlace) -> bytes:
    return bytes_at(file, frame.start, frame.end - frame.start)


def _header(content: Content, data: bytes) -> Content:
    return content._replace(profile=Header.read(stream_of(data)).profile)


def _attachment(content: Content, data: bytes) -> Content:
    (crc,) = _CRC.unpack(data[-_CRC.size :])
    if crc and zlib.crc32(data[: -_CRC.size]) != crc:
        raise ValueError("the checksum does not fit")
    attachment: Attachment = Attachment.read(stream_of(data))
    content.attachments[attachment.name] = attachment
    return content


def _metadata(content: Content, data: bytes) -> Content:
    metadata: Metadata = Metadata.read(stream_of(data))
    content.metadata[metadata.name] = metadata.metadata
    return content


_READ: Final[dict[int, Callable[[Content, bytes], Content]]] = {
    Opcode.HEADER: _header,
    Opcode.ATTACHMENT: _attachment,
    Opcode.METADATA: _metadata,
}


# --- chunks ---------------------------------------------------------------------------------------


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
