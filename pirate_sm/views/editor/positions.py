"""Where places of a file are for an editor, which counts lines and characters in its own way."""

from __future__ import annotations

import re
from bisect import bisect_right
from itertools import accumulate

from lsprotocol.types import Position, Range
from pygls.workspace import PositionCodec

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.reports.check_report import end_column
from pirate_sm.core.documents import Edit, Place

_BREAK = re.compile(r"\r\n|\r|\n")
"""Ends a line for editors; YAML knows three more."""


class Positions:
    """The positions in a text.

    Args:
        text: The text of the file.
        codec: Counts characters as the editor does, mostly in units of UTF-16.
    """

    def __init__(self, text: str, codec: PositionCodec) -> None:
        self._text, self._codec = text, codec
        self._lines = text.splitlines(keepends=True)
        self._begins = [0, *accumulate(map(len, self._lines))]
        self._begins_there = [0, *(each.end() for each in _BREAK.finditer(text))]

    def index(self, line: int, column: int) -> int:
        """Return the index of a place in the text; that of the end of its line if it is short."""
        if not 0 < line <= len(self._lines):
            return len(self._text) if line else 0
        inside = min(max(column - 1, 0), len(self._lines[line - 1].rstrip("\r\n")))
        return self._begins[line - 1] + inside

    def at(self, index: int) -> Position:
        """Return the position of an index in the text."""
        line = bisect_right(self._begins_there, index) - 1
        before = self._text[self._begins_there[line] : index]
        return Position(line, self._codec.client_num_units(before))

    def index_of(self, position: Position) -> int:
        """Return the index of a position; that of the end of its line if it is short."""
        line = min(position.line, len(self._begins_there) - 1)
        begin: int = self._begins_there[line]
        end = self._begins_there[line + 1] if line + 1 < len(self._begins_there) else None
        text = self._text[begin:end].rstrip("\r\n")
        counts = accumulate(map(self._codec.client_num_units, text))
        return begin + sum(int(each <= position.character) for each in counts)

    def between(self, start: int, end: int) -> Range:
        """Return the range of the text from one index to another."""
        return Range(self.at(start), self.at(end))

    @property
    def everything(self) -> Range:
        """Return the range of the whole text."""
        return self.between(0, len(self._text))

    def of_place(self, place: Place, end: int) -> Range:
        """Return the range of a place up to a column of its line."""
        line = place.line
        return self.between(self.index(line, place.column), self.index(line, end if line else 0))

    def of_finding(self, finding: Finding) -> Range:
        """Return the range that a finding marks."""
        return self.of_place(finding.place, end_column(finding))

    def of_edit(self, edit: Edit) -> Range:
        """Return the range that a change replaces."""
        return self.of_place(edit.place, edit.end_column)
