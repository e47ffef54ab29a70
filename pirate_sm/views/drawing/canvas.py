"""A drawing made of braille characters: 2 × 4 dots in each, about square."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from math import cos, floor, hypot, pi, sin
from operator import itemgetter

from rich.text import Text

ACROSS, DOWN = 2, 4
_BLANK = 0x2800
_DASH = 6
"""Dots from one dash to the next."""

_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))


class Canvas:
    """Dots on a grid of characters; a character has the style of what was drawn into it last.

    Attributes:
        dashed: Whether lines and rings have gaps.
    """

    def __init__(self, columns: int, rows: int) -> None:
        self.width, self.height = columns * ACROSS, rows * DOWN
        self._bits = [[0] * columns for _ in range(rows)]
        self._styles = [[""] * columns for _ in range(rows)]
        self._letters: dict[tuple[int, int], str] = {}
        self.dashed = False

    def dot(self, x: float, y: float, style: str) -> None:
        """Draw a dot, unless it is outside; y counts downwards."""
        column, row = floor(x + 0.5), floor(y + 0.5)  # round() leaves gaps at halves
        if 0 <= column < self.width and 0 <= row < self.height:
            across, down = column // ACROSS, row // DOWN
            self._bits[down][across] |= _BITS[row % DOWN][column % ACROSS]
            self._styles[down][across] = style

    def line(self, x0: float, y0: float, x1: float, y1: float, style: str) -> None:
        """Draw a line between two places, as far as it is inside."""
        clipped = _clip(x0, y0, x1, y1, self.width, self.height)
        if clipped is None:
            return
        x0, y0, x1, y1 = clipped
        steps = max(1, round(max(abs(x1 - x0), abs(y1 - y0))))
        for step in range(steps + 1):
            if self.dashed and step % _DASH >= _DASH / 2:
                continue
            share = step / steps
            self.dot(x0 + (x1 - x0) * share, y0 + (y1 - y0) * share, style)

    def disc(self, x: float, y: float, radius: float, style: str) -> None:
        """Draw a filled disc of at least one dot."""
        self.dot(x, y, style)
        for column, row in _within(x, y, radius):
            self.dot(column, row, style)

    def erase(self, x: float, y: float, radius: float) -> None:
        """Erase what is drawn in this disc."""
        for column, row in _within(x, y, radius):
            if 0 <= column < self.width and 0 <= row < self.height:
                self._bits[row // DOWN][column // ACROSS] &= ~_BITS[row % DOWN][column % ACROSS]

    def circle(self, x: float, y: float, radius: float, style: str) -> None:
        """Draw a ring."""
        count = max(8, round(4 * pi * radius))
        for step in range(count):
            if self.dashed and step % _DASH >= _DASH / 2:
                continue
            angle = 2 * pi * step / count
            self.dot(x + radius * cos(angle), y + radius * sin(angle), style)

    def write(self, x: float, y: float, text: str, style: str) -> None:
        """Write a text over what is drawn, its first character at this dot."""
        column, row = floor(x / ACROSS), floor(y / DOWN)
        if 0 <= row < len(self._bits):
            for place, letter in enumerate(text, column):
                if 0 <= place < len(self._bits[row]):
                    self._letters[row, place] = letter
                    self._styles[row][place] = style

    def runs(self) -> Iterator[list[tuple[str, str]]]:
        """Yield for each row of characters the pieces of one style, each as text and style."""
        for row, (bits, styles) in enumerate(zip(self._bits, self._styles, strict=True)):
            letters = [
                self._letters.get((row, column)) or (chr(_BLANK + bit) if bit else " ")
                for column, bit in enumerate(bits)
            ]
            pieces = groupby(zip(styles, letters, strict=True), key=itemgetter(0))
            yield [("".join(letter for _, letter in piece), style) for style, piece in pieces]

    def rows(self) -> list[Text]:
        """Return one line of text per row of characters."""
        lines = []
        for pieces in self.runs():
            line = Text(no_wrap=True, end="")
            for text, style in pieces:
                line.append(text, style or None)
            lines.append(line)
        return lines


def _within(x: float, y: float, radius: float) -> Iterator[tuple[int, int]]:
    """Yield column and row of each dot of a disc."""
    reach = int(radius) + 1
    for row in range(round(y) - reach, round(y) + reach + 1):
        for column in range(round(x) - reach, round(x) + reach + 1):
            if hypot(column - x, row - y) <= radius:
                yield column, row


def _clip(
    x0: float, y0: float, x1: float, y1: float, width: float, height: float
) -> tuple[float, float, float, float] | None:
    """Return the part of a line inside the grid (Liang and Barsky 1984); None without one."""
    dx, dy = x1 - x0, y1 - y0
    enter, leave = 0.0, 1.0
    for toward, room in ((-dx, x0), (dx, width - x0), (-dy, y0), (dy, height - y0)):
        if toward == 0:
            if room < 0:
                return None
            continue
        share = room / toward
        if toward < 0:
            enter = max(enter, share)
        else:
            leave = min(leave, share)
    if enter > leave:
        return None
    return x0 + enter * dx, y0 + enter * dy, x0 + leave * dx, y0 + leave * dy
