"""Finds the lines of a mission's file that describe each phase and each end."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping

from pirate_sm.core import models as model
from pirate_sm.core.documents import Document
from pirate_sm.views.report.contents import PhaseLines


def phase_lines(source: Document, mission: model.Mission) -> Mapping[str, PhaseLines]:
    """Return the lines of each phase and each end of the mission, by its name.

    Those of a file that this one extends are left out.
    """
    named = [("phases", name) for name in mission.phases] + [
        ("ends", name) for name in mission.ends
    ]
    places = {name: source.place_of((where, name), key=True) for where, name in named}
    tops = {source.place_of((key,), key=True).line for key in source.data}
    own = {name: place.line for name, place in places.items() if place.file == source.name}
    starts = sorted({*tops, *own.values(), len(source.lines) + 1})
    return {
        name: PhaseLines(line, _without_rest(source.lines[line - 1 : _after(starts, line) - 1]))
        for name, line in own.items()
    }


def _after(starts: list[int], line: int) -> int:
    return starts[bisect_right(starts, line)]


def _without_rest(lines: tuple[str, ...]) -> str:
    """Return the lines without empty ones and comments at their end, which belong to what follows.

    The last line of a file has nothing below it.
    """
    found = [line.rstrip() for line in lines]
    while len(found) > 1 and found[-1].lstrip()[:1] in ("", "#"):
        found.pop()
    return "\n".join(found)
