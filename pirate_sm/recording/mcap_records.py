"""The records of an MCAP file, as far as it goes: whole, torn at its end, or damaged.

The official reader stops with one of many exceptions where a file ends early. Here the frames are
walked by their lengths first, so that a record that is not all there is told from one that is
wrong. Of the file only the chunk that is being read is in memory.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import BinaryIO, Final, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Metadata, Schema
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

LARGEST_CHUNK: Final = 1 << 28
"""What a chunk or a text may become: ours are far smaller, and a few bytes can claim any size."""

_FRAME: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<HIQQ")
_TIME: Final = struct.Struct("<Q")
_CRC: Final = struct.Struct("<I")
_FOOTER: Final = struct.Struct("<BQQQI")
_BROKEN: Final = (
    McapError, CRCValidationError, ValueError, OverflowError, struct.error, zstandard.ZstdError,
)  # fmt: skip


class NotMcapError(Exception):
    """The bytes are something else."""


class DamagedError(Exception):
    """Bytes are not what was written, and more of it follows."""


class Piece(NamedTuple):
    """A chunk in the file.

    Attributes:
        at: Where what is in it begins, byte; ``size`` how many these are.
        start_ns: When its first message was.
    """

    at: int
    size: int
    start_ns: int


class Content(NamedTuple):
    """What is in the file.

    Attributes:
        profile: Who says what the rest means; None when not even that is there.
        attachments: By name.
        metadata: By name.
        pieces: The chunks. One that was changed is noticed when it is read.
        complete: Whether all of it is there: what comes after is only the index of it.
        indexed: Whether that index is there, too, as it was written.
        damage: Where bytes begin that are not what was written; empty where there are none.
        whole: How many bytes are whole records; what follows is torn.
        size: Of the file, bytes.
    """

    profile: str | None
    attachments: dict[str, Attachment]
    metadata: dict[str, dict[str, str]]
    pieces: list[Piece]
    complete: bool
    whole: int
    size: int
    indexed: bool = False
    damage: str = ""


class Entry(NamedTuple):
    """A message.

    Attributes:
        number: Of its topic, see :class:`FileTopics`.
        time_ns: When it was, ns since 1970.
        data: What it says.
    """

    number: int
    time_ns: int
    data: bytes


def read_content(file: BinaryIO) -> Content:
    """Everything up to the end of the file, to the tear where writing was cut short, or to damage.

    Raises:
        NotMcapError: It is something else.
        OSError: It cannot be read.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    if not MCAP0_MAGIC.startswith(file.read(len(MCAP0_MAGIC))):
        raise NotMcapError
    content, bad, good, end = Content(None, {}, {}, [], False, 0, size), [], 0, len(MCAP0_MAGIC)
    for frame in _frames(file, size):
        end = frame.end
        try:
            if frame.opcode == Opcode.CHUNK:
                content.pieces.append(_piece(file, frame))
            elif frame.opcode in _READ:
                content = _READ[frame.opcode](content, _small(file, frame))
                good = frame.start
        except _BROKEN:
            bad.append(frame.start)
        if frame.opcode == Opcode.DATA_END:
            content = content._replace(complete=True)
    broken = not content.complete and size > len(MCAP0_MAGIC) and _ends_whole(file, size)
    if not content.complete:
        bad += _torn(file, content.pieces)
    good = max(good, content.pieces[-1].at if content.pieces else 0)
    if broken or (bad and (content.complete or min(bad) < good)):
        return _up_to(content, min([*bad, end]))
    whole = size if content.complete else min([*(at - _FRAME.size for at in bad), end])
    return content._replace(whole=whole, indexed=content.complete and _has_index(file, size))


def _up_to(content: Content, at: int) -> Content:
    """What comes before the damage at a byte."""
    pieces = [piece for piece in content.pieces if piece.at + piece.size <= at]
    whole = pieces[-1].at + pieces[-1].size if pieces else min(at, content.size)
    return content._replace(pieces=pieces, complete=False, whole=whole, damage=f"at byte {at}")


def records_of(file: BinaryIO, piece: Piece) -> bytes:
    """What is in a chunk.

    Raises:
        DamagedError: It is not what was written.
        OSError: It cannot be read.
    """
    try:
        chunk: Chunk = Chunk.read(_stream(_bytes(file, piece.at, piece.size)))
        size = chunk.uncompressed_size
        if chunk.compression == "zstd":
            size = max(size, zstandard.frame_content_size(chunk.data))
        if size > LARGEST_CHUNK:
            raise ValueError("the chunk is larger than any of ours")
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
        records: bytes = stream.read(length)
    except _BROKEN:
        raise DamagedError(f"at byte {piece.at}") from None
    return records


class FileTopics:
    """The topics of a file, by their numbers; a number stands for one and the same all along."""

    def __init__(self) -> None:
        self.names: dict[int, str] = {}
        self.channels: dict[int, Channel] = {}
        self.schemas: dict[int, Schema] = {}

    def learn(self, records: bytes) -> None:
        """The topics that begin in this chunk are known."""
        for opcode, start, end in _inside(records):
            if opcode == Opcode.CHANNEL:
                channel: Channel = Channel.read(_stream(records[start:end]))
                self.channels[channel.id] = channel
                self.names[channel.id] = channel.topic
            elif opcode == Opcode.SCHEMA:
                schema: Schema = Schema.read(_stream(records[start:end]))
                self.schemas[schema.id] = schema

    def described(self, number: int) -> tuple[str, str, bytes]:
        """A topic, the name of its schema and that schema; empty without one."""
        channel = self.channels[number]
        schema = self.schemas.get(channel.schema_id)
        return (channel.topic, schema.name, schema.data) if schema else (channel.topic, "", b"")


def messages_in(records: bytes) -> Iterator[Entry]:
    """The messages of a chunk, in the order of writing."""
    for opcode, start, end in _inside(records):
        if opcode == Opcode.MESSAGE:
            number, _, time_ns, _ = _MESSAGE.unpack_from(records, start)
            yield Entry(number, time_ns, records[start + _MESSAGE.size : end])


class _Frame(NamedTuple):
    """A record's place in the file."""

    opcode: int
    start: int
    end: int


def _frames(file: BinaryIO, size: int) -> Iterator[_Frame]:
    """The records that are all there, by their lengths."""
    at = len(MCAP0_MAGIC)
    while at + _FRAME.size <= size:
        file.seek(at)
        opcode, length = _FRAME.unpack(file.read(_FRAME.size))
        start, end = at + _FRAME.size, at + _FRAME.size + length
        if opcode == 0 or end > size:
            return
        yield _Frame(opcode, start, end)
        if opcode == Opcode.DATA_END:
            return
        at = end


def _has_index(file: BinaryIO, size: int) -> bool:
    """Whether the file ends with the index that other programs look for, as it was written."""
    at = size - _FOOTER.size - len(MCAP0_MAGIC)
    if at < 0 or not _ends_whole(file, size):
        return False
    footer = _bytes(file, at, _FOOTER.size)
    opcode, length, begins, _, crc = _FOOTER.unpack(footer)
    if (opcode, length) != (Opcode.FOOTER, _FOOTER.size - _FRAME.size) or not 0 < begins <= at:
        return False
    try:
        index = _bytes(file, begins, at - begins)
    except ValueError:
        return False
    return bool(zlib.crc32(footer[: -_CRC.size], zlib.crc32(index)) == crc)


def _inside(records: bytes) -> Iterator[_Frame]:
    """The records in a chunk.

    Raises:
        DamagedError: One goes beyond its end.
    """
    at, size = 0, len(records)
    while at + _FRAME.size <= size:
        opcode, length = _FRAME.unpack_from(records, at)
        start, at = at + _FRAME.size, at + _FRAME.size + length
        if at > size or (opcode == Opcode.MESSAGE and length < _MESSAGE.size):
            raise DamagedError("a chunk holds something else than records")
        yield _Frame(opcode, start, at)


def _ends_whole(file: BinaryIO, size: int) -> bool:
    return _bytes(file, size - len(MCAP0_MAGIC), len(MCAP0_MAGIC)) == MCAP0_MAGIC


def _torn(file: BinaryIO, pieces: list[Piece]) -> Iterator[int]:
    """Where each chunk begins that writing was cut short in; these are no longer among them."""
    while pieces:
        try:
            records_of(file, pieces[-1])
        except DamagedError:
            yield pieces.pop().at
        else:
            return


def _piece(file: BinaryIO, frame: _Frame) -> Piece:
    (start_ns,) = _TIME.unpack(_bytes(file, frame.start, min(_TIME.size, frame.end - frame.start)))
    return Piece(frame.start, frame.end - frame.start, start_ns)


def _small(file: BinaryIO, frame: _Frame) -> bytes:
    return _bytes(file, frame.start, frame.end - frame.start)


def _bytes(file: BinaryIO, at: int, size: int) -> bytes:
    if size > LARGEST_CHUNK:
        raise ValueError("it is larger than any of ours")
    file.seek(at)
    return file.read(size)


def _header(content: Content, data: bytes) -> Content:
    return content._replace(profile=Header.read(_stream(data)).profile)


def _attachment(content: Content, data: bytes) -> Content:
    (crc,) = _CRC.unpack(data[-_CRC.size :])
    if crc and zlib.crc32(data[: -_CRC.size]) != crc:
        raise ValueError("the checksum does not fit")
    attachment: Attachment = Attachment.read(_stream(data))
    content.attachments[attachment.name] = attachment
    return content


def _metadata(content: Content, data: bytes) -> Content:
    metadata: Metadata = Metadata.read(_stream(data))
    content.metadata[metadata.name] = metadata.metadata
    return content


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


_READ: Final[dict[int, Callable[[Content, bytes], Content]]] = {
    Opcode.HEADER: _header,
    Opcode.ATTACHMENT: _attachment,
    Opcode.METADATA: _metadata,
}
