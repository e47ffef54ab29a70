"""The records of an MCAP file, as far as it goes: whole, torn at its end, or damaged.

The official reader stops with one of many exceptions where a file ends early. Here the frames are
walked by their lengths first, so that a record that is not all there is told from one that is
wrong; what is inside each is left to the library.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import Any, Final, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Message
from mcap.stream_reader import CRCValidationError, breakup_chunk
from mcap.writer import MCAP0_MAGIC

LARGEST_CHUNK: Final = 1 << 28
"""What a chunk may become: ours are far smaller, and a few bytes can claim any size."""

_FRAME: Final = struct.Struct("<BQ")
_CRC: Final = struct.Struct("<I")
_BROKEN: Final = (
    McapError, CRCValidationError, ValueError, OverflowError, struct.error, zstandard.ZstdError,
)  # fmt: skip


class NotMcapError(Exception):
    """The bytes are something else."""


class DamagedError(Exception):
    """Bytes are not what was written, and more of it follows."""


class Content(NamedTuple):
    """What is in the file.

    Attributes:
        profile: Who says what the rest means; None when not even that is there.
        attachments: By name.
        chunks: Each whole and of the right checksum.
        complete: Whether it was written to its end.
    """

    profile: str | None
    attachments: dict[str, Attachment]
    chunks: tuple[Chunk, ...]
    complete: bool


def read_content(data: bytes) -> Content:
    """Everything up to the end of the file, or to the tear where writing was cut short.

    Raises:
        NotMcapError: It is something else.
        DamagedError: It was changed later.
    """
    if not data.startswith(MCAP0_MAGIC[: len(data)]):
        raise NotMcapError
    frames = list(_frames(data))
    complete = bool(frames) and frames[-1].opcode == Opcode.FOOTER
    if not complete and data.endswith(MCAP0_MAGIC) and len(data) > len(MCAP0_MAGIC):
        raise DamagedError(f"at byte {frames[-1].end if frames else len(MCAP0_MAGIC)}")
    profile: str | None = None
    attachments: dict[str, Attachment] = {}
    chunks: list[Chunk] = []
    torn: int | None = None
    for frame in frames:
        if frame.opcode not in _READ:
            continue
        try:
            record = _READ[frame.opcode](data[frame.start : frame.end])
        except _BROKEN:
            if complete or torn is not None:
                raise DamagedError(f"at byte {frame.start}") from None
            torn = frame.start
            continue
        if torn is not None:
            raise DamagedError(f"at byte {torn}")
        if isinstance(record, Header):
            profile = record.profile
        elif isinstance(record, Attachment):
            attachments[record.name] = record
        else:
            chunks.append(record)
    return Content(profile, attachments, tuple(chunks), complete)


def messages_of(chunk: Chunk, topics: dict[int, str]) -> list[tuple[str, Message]]:
    """Topic and message of everything in a chunk, in the order of writing.

    Args:
        chunk: One that has been found whole.
        topics: Topics by number, which grows by those that the chunk begins.

    Raises:
        DamagedError: A message has no topic.
    """
    found: list[tuple[str, Message]] = []
    for record in breakup_chunk(chunk):
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            if record.channel_id not in topics:
                raise DamagedError(f"channel {record.channel_id} is unknown")
            found.append((topics[record.channel_id], record))
    return found


class _Frame(NamedTuple):
    """A record's place in the file."""

    opcode: int
    start: int
    end: int


def _frames(data: bytes) -> Iterator[_Frame]:
    """The records that are all there, by their lengths."""
    at = len(MCAP0_MAGIC)
    while at + _FRAME.size <= len(data):
        opcode, length = _FRAME.unpack_from(data, at)
        start, end = at + _FRAME.size, at + _FRAME.size + length
        if opcode == 0 or end > len(data):
            return
        yield _Frame(opcode, start, end)
        if opcode == Opcode.FOOTER:
            return
        at = end


def _header(data: bytes) -> Header:
    header: Header = Header.read(_stream(data))
    return header


def _attachment(data: bytes) -> Attachment:
    (crc,) = _CRC.unpack(data[-_CRC.size :])
    if crc and zlib.crc32(data[: -_CRC.size]) != crc:
        raise ValueError("the checksum does not fit")
    attachment: Attachment = Attachment.read(_stream(data))
    return attachment


def _chunk(data: bytes) -> Chunk:
    chunk: Chunk = Chunk.read(_stream(data))
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":
        size = max(size, zstandard.frame_content_size(chunk.data))
    if size > LARGEST_CHUNK:
        raise ValueError("the chunk is larger than any of ours")
    breakup_chunk(chunk, validate_crc=True)
    return chunk


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


_READ: Final[dict[int, Callable[[bytes], Any]]] = {
    Opcode.HEADER: _header,
    Opcode.ATTACHMENT: _attachment,
    Opcode.CHUNK: _chunk,
}
