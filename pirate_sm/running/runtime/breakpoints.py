"""Where a mission can pause: before its phases, its ends and the lines that do something.

A breakpoint is the place of an instruction, ``file:line:col``. The engine pauses before any
instruction of that place: in each round of a repeat, and wherever its mission is called.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

from pirate_sm.core.documents import Document, Place
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Enter, Finish
from pirate_sm.core.spelling import meant

_DIGITS = 10
"""No file has a line with a number of so many digits, and Python does not read one of thousands."""


class Breakable(NamedTuple):
    """A line before which a mission can pause: its first instruction.

    Attributes:
        place: Where the instruction is.
        line: The line that people take for it: of a phase or an end that of its name.
        name: The phase or the end that begins there; empty for a step.
        text: The line of the file.
    """

    place: Place
    line: int
    name: str
    text: str


def breakables(loaded: LoadedMission) -> tuple[Breakable, ...]:
    """Return where the mission can pause: each line once, file by file from the top."""
    program, found = loaded.program, dict[tuple[str, int], Breakable]()
    files = {each.name: each for each in loaded.documents}
    heads = {place: line for each in files.values() for place, line in _heads(each)}
    for it, phase in zip(program.instructions, program.phase_of, strict=True):
        if it.place.count(":") < 2:  # it is in no file: a command that restores the robot's states
            continue
        place = Place.read(it.place)
        name = phase if isinstance(it, Enter) else it.end if isinstance(it, Finish) else ""
        line, known = heads.get(it.place, place.line) if name else place.line, files.get(place.file)
        earlier = found.get((place.file, place.line))
        if earlier is None or place.column < earlier.place.column:
            text = known.lines[line - 1].strip() if known is not None else ""
            found[place.file, place.line] = Breakable(place, line, name, text)
    order = {name: at for at, name in enumerate(files)}
    return tuple(
        sorted(found.values(), key=lambda each: (order.get(each.place.file, 0), each.place))
    )


def _heads(document: Document) -> Iterator[tuple[str, int]]:
    """Yield the place of the content of each phase and end, and the line of its name."""
    for section in ("phases", "ends"):
        named = document.data.get(section) if isinstance(document.data, Mapping) else None
        for name in named if isinstance(named, Mapping) else ():
            with suppress(LookupError):
                place = document.place_of((section, name))
                yield str(place), document.place_of((section, name), key=True).line


def breakpoints(loaded: LoadedMission, texts: Sequence[str], says: str = "") -> tuple[str, ...]:
    """Return the places of breakpoints, each as ``PHASE``, ``LINE`` or ``FILE:LINE``.

    Args:
        loaded: The mission. A line without a file is one of its own file.
        texts: The breakpoints; an end of the mission counts as a phase.
        says: What is said before each that cannot be used.

    Raises:
        UsageError: The mission cannot pause at some of them; all of these are named.
    """
    found, wrong = dict[str, None](), []
    where = breakables(loaded) if texts else ()
    for text in texts:
        try:
            found[str(_found(text.strip(), loaded, where).place)] = None
        except UsageError as error:
            wrong.append(f"{says}{text}: {error}")
    if wrong:
        raise UsageError("\n".join(wrong))
    return tuple(found)


def _found(text: str, loaded: LoadedMission, where: Sequence[Breakable]) -> Breakable:
    """Return the line that is meant.

    Raises:
        UsageError: There is none.
    """
    file, _, line = text.rpartition(":")
    if not (line.isascii() and line.isdecimal() and len(line) < _DIGITS):
        named = {each.name: each for each in where if each.name}
        if text not in named:
            raise UsageError(f"the mission has no such phase: {meant(text, named)}")
        return named[text]
    own = loaded.documents[0].name
    files = dict.fromkeys(each.place.file for each in where)
    name = _file(file, files) if file else own
    if not name:
        raise UsageError(f"the mission consists of no such file: {meant(file, files)}")
    here, number = [each for each in where if each.place.file == name], int(line)
    for each in here:
        if number in (each.place.line, each.line):
            return each
    near = min(here, key=lambda each: abs(each.line - number), default=None)
    hint = f"; the nearest line that has one is {near.line} ({near.text})" if near else ""
    raise UsageError(f"nothing begins in line {number} of {name}{hint}")


def _file(text: str, files: Collection[str]) -> str:
    """Return the file that is meant by its name or the end of its path; empty if none is."""
    ends = [each for each in files if each == text or each.endswith(f"/{text}")]
    return text if text in files else ends[0] if len(ends) == 1 else ""
