"""Reads what is in files for a shell; what cannot be read is empty."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from pirate_sm.core.errors import PirateError
from pirate_sm.core.files import library
from pirate_sm.core.on_disk import opened

Candidate: TypeAlias = tuple[str, str]
"""A value, and a line about it."""

OPEN = ("/", "=", ":", ",")
"""Signs behind which a value goes on."""

RECORDING = ".mcap"


def read(path: Path) -> Mapping[Any, Any]:
    """Return what is in a file; nothing if it cannot be read."""
    from pirate_sm.core.documents import read_document

    try:
        return mapping(read_document(path).data)
    except (PirateError, OSError, ValueError):
        return {}


def read_extended(path: Path) -> Mapping[Any, Any]:
    """Return what is in a file and in the one that it extends; nothing if they cannot be read."""
    from pirate_sm.core.documents import extended_file

    try:
        return mapping(extended_file.read_extended(path).data)
    except (PirateError, OSError, ValueError):
        return {}


def recorded(path: Path, role: str) -> Mapping[Any, Any]:
    """Return what was in the file of a recording's mission or robot; it may be cut off."""
    from mcap.records import Attachment, Chunk
    from mcap.stream_reader import StreamReader

    from pirate_sm.core.documents import parse_document

    with opened(path) as file:
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, Attachment) and record.name.endswith(f"_{role}.yaml"):
                return mapping(parse_document(record.data, record.name).data)
            if isinstance(record, Chunk):  # the run begins, and the files stand before it
                break
    return {}


def about_file(path: Path) -> str:
    """Return the description in a file; empty if there is none."""
    return line(read(path).get("description")) if path.suffix in library.SUFFIXES else ""


def described(found: Any) -> Iterator[Candidate]:
    """Yield the keys of a mapping with the descriptions in their values."""
    for name, each in mapping(found).items():
        yield str(name), line(mapping(each).get("description"))


def mapping(found: Any) -> Mapping[Any, Any]:
    """Return a mapping as it is; of anything else an empty one."""
    return found if isinstance(found, dict) else {}


def items(found: Any, key: str) -> list[Any]:
    """Return the list at a key of a mapping; an empty one if there is none."""
    listed = mapping(found).get(key)
    return listed if isinstance(listed, list) else []


def line(found: Any) -> str:
    """Return a text or a number as text; of anything else an empty one."""
    return str(found) if isinstance(found, str | int | float) else ""
