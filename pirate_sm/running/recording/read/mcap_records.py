"""Reads the chunks of an MCAP file and their records, with one chunk in memory at a time."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from io import BytesIO
from typing import BinaryIO, Final, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream

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
