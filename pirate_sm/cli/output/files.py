"""Writes the output files and tables of a command, never over what a user has written."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from io import StringIO
from pathlib import Path

from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import is_file, is_folder, is_there, opened, replace_file
from pirate_sm.core.visible import visible
from pirate_sm.views.report import GENERATOR

HEAD = 20_000
"""The part of a file in which a mark of this program is sought, bytes [decided]."""

_TAIL = 100_000
"""The part of a Parquet file, whose metadata are at its end, bytes [decided]."""

_MARKS: dict[str, tuple[bytes, ...]] = {
    ".html": (GENERATOR,),
    ".info": (b"TN:pirate-sm\n",),
    ".md": (b" from the robot's profile and chart. -->",),
    ".svg": (
        b'<svg xmlns="http://www.w3.org/2000/svg" class="drawing" role="img"',
        b'<svg xmlns="http://www.w3.org/2000/svg" class="sheet"',
    ),
    ".h": (b"written by `pirate firmware ",),
    ".parquet": (b"pirate-sm",),
    **dict.fromkeys((".log", ".jsonl"), (b'{"at_s": ',)),
    **dict.fromkeys((".dot", ".gv"), (b"labelloc=t, labeljust=l, fontname=monospace]",)),
    **dict.fromkeys((".mmd", ".mermaid"), (b'---\ntitle: "',)),
}
"""What identifies a file of this program that nobody edits, by its ending.

YAML, SCXML, URDF and layouts are not here: people edit these further.
"""


def refuse_losses(
    places: Iterable[Path | None],
    *,
    inputs: Iterable[Path] = (),
    tables: Iterable[str] = (),
    overwrite: bool = False,
) -> None:
    """Refuse to write over a file that may be the only one of its kind.

    A file that this program made and that is not edited, such as a drawing, is overwritten.

    Args:
        places: The files to write.
        inputs: What the command reads: files, or folders with all that is in them. These are
            never written over, whatever their names are (links to them are the same file).
        tables: First lines of the tables that the command writes.
        overwrite: Whether the user agrees to lose other files.

    Raises:
        UsageError: A file is a recording, an input, somebody's work, or is named twice; the
            message lists all.
    """
    named, tables = [place for place in places if place is not None], frozenset(tables)
    whole = [place.resolve() for place in named]
    read = [file for each in inputs for file in (each.rglob("*") if is_folder(each) else [each])]
    problems = []
    for place in dict.fromkeys(named):
        if is_recording(place):
            problems.append(f"'{place}' is a recording: nothing is written over it")
        elif any(_is_same(place, each) for each in read):
            problems.append(f"'{place}' is read by this command: name another file to write")
        elif not overwrite and is_file(place) and not is_made(place, tables):
            problems.append(
                f"'{place}' exists and was not written by this program; not overwritten: "
                "name another file, or lose this one with --overwrite"
            )
    twice = [place for number, place in enumerate(named) if whole[number] in whole[:number]]
    problems += [f"'{place}' is named twice: each file needs its own name" for place in twice]
    if problems:
        raise UsageError("\n".join(problems))


def is_made(place: Path, tables: Iterable[str] = ()) -> bool:
    """Return whether this program made the file and nobody edits such files; also if empty."""
    suffix = place.suffix.lower()
    head = _ends(place, _TAIL) if suffix == ".parquet" else begins(place, HEAD)
    if not head or (suffix == ".csv" and first_line(place) in tables):
        return True
    return any(mark in head for mark in _MARKS.get(suffix, ()))


def _is_same(place: Path, other: Path) -> bool:
    with suppress(OSError, ValueError):
        return place.samefile(other)
    return False


def is_recording(place: Path) -> bool:
    """Return whether there is a file that begins like a recording."""
    from mcap.writer import MCAP0_MAGIC

    return begins(place, len(MCAP0_MAGIC)) == MCAP0_MAGIC


def begins(place: Path, size: int) -> bytes:
    """Return the first bytes of a file; none of a terminal and the like, or where none is."""
    with suppress(OSError, ValueError), opened(place) as file:
        return file.read(size)
    return b""


def first_line(place: Path) -> str:
    """Return the first line of a text file."""
    return begins(place, HEAD).partition(b"\n")[0].decode(errors="replace")


def _ends(place: Path, size: int) -> bytes:
    """Return the last bytes of a file; none of a terminal and the like, or where none is."""
    with suppress(OSError, ValueError), opened(place) as file:
        file.seek(max(0, place.stat().st_size - size))
        return file.read()
    return b""


def write_file(place: Path, text: str) -> None:
    """Write the text to the file: all of it, or nothing.

    Raises:
        UsageError: It cannot be written; what was there before stays.
    """
    write_bytes(place, text.encode("utf-8"))


def write_and_name(place: Path, text: str) -> None:
    """Write the text to the file, and print its path.

    Raises:
        UsageError: It cannot be written; what was there before stays.
    """
    write_file(place, text)
    print(visible(str(place)))


def write_or_print(place: Path | None, text: str) -> None:
    """Write the text to the file, or to standard output if no file is named.

    Raises:
        UsageError: The file cannot be written; what was there before stays.
    """
    if place is None:
        sys.stdout.write(text)
    else:
        write_file(place, text)


def write_bytes(place: Path, content: bytes) -> None:
    """Write the content to the file: all of it, or nothing.

    A link stays a link. What is not a file, such as a terminal or a pipe, is written to directly.

    Raises:
        UsageError: It cannot be written; what was there before stays.
    """
    try:
        whole = place.resolve()
        if not is_there(whole.parent):
            raise UsageError(f"'{place}' cannot be written: there is no folder '{place.parent}'")
        if is_there(whole) and not is_file(whole):
            whole.write_bytes(content)
        else:
            replace_file(whole, content)
    except (OSError, RuntimeError) as error:  # RuntimeError: a link that leads to itself
        why = error.strerror if isinstance(error, OSError) else str(error)
        raise UsageError(f"'{place}' cannot be written: {why}") from None


def write_csv(place: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table; an unknown number is an empty cell.

    Raises:
        UsageError: The file cannot be written.
    """
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow(["" if each != each else each for each in row])  # noqa: PLR0124
    write_file(place, text.getvalue())


def csv_line(header: Sequence[str]) -> str:
    """Return the first line of a table."""
    return ",".join(header)
