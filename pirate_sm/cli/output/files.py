"""Writes the output files of a command, without overwriting a recording or another output."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from pirate_sm.errors import UsageError


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


def write_file(place: Path, text: str) -> None:
    """Write the text to the file.

    Raises:
        UsageError: It cannot be written; what was begun of the file is removed.
    """
    opened = False
    try:
        with place.open("w", encoding="utf-8") as file:
            opened = True
            file.write(text)
    except OSError as error:
        if opened and place.is_file():
            with suppress(OSError):
                place.unlink()
        raise UsageError(f"'{place}' cannot be written: {error.strerror}") from None
