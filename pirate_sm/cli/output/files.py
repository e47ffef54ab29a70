"""Writes the output files of a command, and never writes over what somebody else has written."""

from __future__ import annotations

import os
import re
import stat
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from pirate_sm.errors import UsageError

_YAML = (".yaml", ".yml")

_GENERATOR = '<meta name="generator" content="pirate-sm '
"""The line that identifies a page of any version of this program."""

_PAGE_HEAD = 2_000
"""The part of a page that contains the name of its generator."""

_HEAD = 120
"""So much of a file says what it is."""

_SURELY = 20
"""What stands in quotes may be this many times as long as the rest."""


def refuse_losses(places: Iterable[Path]) -> None:
    """Refuse to overwrite a recording, or to write twice to one file.

    Args:
        places: The files to write.

    Raises:
        UsageError: A file is a recording or is named twice; the message lists all.
    """
    places = list(places)
    whole = [place.resolve() for place in places]
    recordings = filter(is_recording, dict.fromkeys(places))
    problems = [f"'{place}' is a recording: nothing is written over it" for place in recordings]
    twice = [place for number, place in enumerate(places) if whole[number] in whole[:number]]
    problems += [f"'{place}' is named twice: each file needs its own name" for place in twice]
    if problems:
        raise UsageError("\n".join(problems))


def is_recording(place: Path) -> bool:
    """Return whether there is a file that begins like a recording."""
    from mcap.writer import MCAP0_MAGIC

    return begins(place, len(MCAP0_MAGIC)) == MCAP0_MAGIC


def begins(place: Path, size: int) -> bytes:
    """Return the first bytes of a file; none of a terminal and the like, or where none is."""
    with suppress(OSError, ValueError):
        if place.is_file():
            with place.open("rb") as file:
                return file.read(size)
    return b""


def refuse_written(place: Path) -> None:
    """Refuse a new YAML file where there is a file already: people write and edit those.

    Raises:
        UsageError: There is such a file.
    """
    if place.is_file() and place.stat().st_size:
        raise UsageError(f"'{place}' exists, and it stays: move it away, or name another file")


def is_page(place: Path) -> bool:
    """Return whether there is a page that any version of this program made."""
    return _GENERATOR in begins(place, _PAGE_HEAD).decode(errors="replace")


def write_file(place: Path, text: str, *, edited: bool = False, head: int = _HEAD) -> None:
    """Write the text to the file, whole or not at all.

    A file that exists is replaced only if it begins as the new one does, so that a drawing can be
    drawn again; a page, if this program made it. A YAML file is never replaced.

    Args:
        place: The file.
        text: What it is to contain.
        edited: Whether the text is that of the file, with something changed in it.
        head: How many characters must be alike, but for what stands in quotes.

    Raises:
        UsageError: It cannot be written, or there is a file that was not written by this command.
    """
    if not edited:
        _refuse_another(place, text, head)
    try:
        _replace(place, text)
    except OSError as error:
        raise UsageError(f"'{place}' cannot be written: {error.strerror}") from None


def _refuse_another(place: Path, text: str, head: int) -> None:
    if place.suffix in _YAML:
        refuse_written(place)
        return
    old = begins(place, _SURELY * head).decode(errors="replace")
    if _GENERATOR in text[:_PAGE_HEAD]:
        alike = is_page(place)
    else:
        alike = _unquoted(text, head).startswith(_unquoted(old, head))
    if old.strip() and not alike:
        raise UsageError(
            f"'{place}' exists and contains something else, so it stays: move it away, or name "
            "another file"
        )


def _unquoted(text: str, head: int) -> str:
    """Return the beginning of a text, without what stands in quotes."""
    return re.sub(r"\"[^\"]*\"", "", text)[:head]


def _replace(place: Path, text: str) -> None:
    """Write a file beside the place and move it there; a device or a pipe is written as it is.

    Raises:
        OSError: It cannot be written; an old file is as it was.
    """
    place = place.resolve()  # a link stays one
    if place.exists() and not place.is_file():
        with place.open("w", encoding="utf-8") as file:
            file.write(text)
        return
    handle, beside = tempfile.mkstemp(prefix=f".{place.name}.", dir=place.parent)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        Path(beside).chmod(_mode(place))
        Path(beside).replace(place)
    except BaseException:
        with suppress(OSError):
            Path(beside).unlink()
        raise


def _mode(place: Path) -> int:
    """Return the permissions of the file, or those of a new one."""
    with suppress(OSError):
        return stat.S_IMODE(place.stat().st_mode)
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
