"""A terminal that remembers what is shown on it: the cursor, erasing, characters in places."""

from __future__ import annotations

import codecs
import re
from unicodedata import east_asian_width

_SEQUENCE = re.compile(
    r"\x1b\[(?P<numbers>[?>=<]?[\d;:]*)(?P<final>[ !$'\"]?[@-~])"
    r"|\x1b[P\]_^X].*?(?:\x1b\\|\x07)"
    r"|\x1b[ #()%*+].|\x1b[=>78cDEHMNOZ]",
    re.DOTALL,
)
_UNFINISHED = re.compile(r"\x1b(?:\[[?>=<\d;: ]*|[P\]_^X][^\x07]*|[ #()%*+]?)?\Z")


class Screen:
    """What a person sees on a terminal of this size."""

    def __init__(self, columns: int, rows: int) -> None:
        self.columns, self.rows = columns, rows
        self.cells = [[" "] * columns for _ in range(rows)]
        self._row = self._column = 0
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._rest = ""

    def feed(self, data: bytes) -> None:
        """Show what was written to the terminal."""
        text = self._rest + self._decoder.decode(data)
        unfinished = _UNFINISHED.search(text)
        self._rest = unfinished.group() if unfinished else ""
        text = text[: len(text) - len(self._rest)]
        at = 0
        for found in _SEQUENCE.finditer(text):
            self._put(text[at : found.start()])
            self._obey(found["final"], found["numbers"])
            at = found.end()
        self._put(text[at:])

    def text(self) -> str:
        """The lines of the screen."""
        return "\n".join("".join(row).rstrip() for row in self.cells)

    def _put(self, text: str) -> None:
        for letter in text:
            if letter == "\r":
                self._column = 0
            elif letter == "\n":
                self._row = min(self._row + 1, self.rows - 1)
            elif letter >= " ":
                if self._column < self.columns:
                    self.cells[self._row][self._column] = letter
                self._column += 2 if east_asian_width(letter) in "WF" else 1

    def _obey(self, final: str | None, numbers: str | None) -> None:
        given = [int(each) for each in (numbers or "").split(";") if each.isdigit()]
        first = given[0] if given else 0
        if final in ("H", "f"):
            row, column = (*given, 1, 1)[:2] if len(given) != 1 else (first, 1)
            self._row = min(max(row - 1, 0), self.rows - 1)
            self._column = max(column - 1, 0)
        elif final == "J":
            self.cells = [[" "] * self.columns for _ in range(self.rows)]
        elif final == "K":
            self.cells[self._row][self._column :] = [" "] * (self.columns - self._column)
        elif final == "G":
            self._column = max(first - 1, 0)
        elif final in ("A", "B", "C", "D"):
            by = max(first, 1)
            down = {"A": -by, "B": by}.get(final, 0)
            self._row = min(max(self._row + down, 0), self.rows - 1)
            self._column = max(self._column + {"C": by, "D": -by}.get(final, 0), 0)
