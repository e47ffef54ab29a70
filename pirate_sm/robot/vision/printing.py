"""Sheets to print: the chessboard and the tags as SVG, with a ruler to check the scale."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from pirate_sm.core.camera import TagFamily
from pirate_sm.robot.vision.chessboard import Chessboard
from pirate_sm.robot.vision.tags import tag_cells

_PAGE_MM = (297.0, 210.0)
"""A4 across."""

_EDGE_MM, _RULER_MM, _GAP_MM = 10.0, 12.0, 8.0


def board_sheet(board: Chessboard) -> str:
    """Return the sheet of a chessboard; a larger one than A4 becomes a larger sheet."""
    columns, rows = (each + 1 for each in board.inside)
    side = 1000 * board.square_m
    width = max(_PAGE_MM[0], columns * side + 2 * _EDGE_MM)
    height = max(_PAGE_MM[1], rows * side + 2 * _EDGE_MM + _RULER_MM)
    left, top = (width - columns * side) / 2, _EDGE_MM
    shapes = [
        _square(left + column * side, top + row * side, side)
        for row in range(rows)
        for column in range(columns)
        if (row + column) % 2 == 0
    ]
    said = f"{columns} × {rows} squares of {side:g} mm: glue it flat onto a stiff board"
    return _sheet(width, height, shapes, said)


def tag_sheets(family: TagFamily, size_m: float, tags: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield sheets of tags.

    Args:
        family: Their family.
        size_m: Length of the sides of their black squares.
        tags: Number of each tag, and what stands below it.
    """
    size = 1000 * size_m
    cell = size / len(tag_cells(family, 0))
    pitch = size + 2 * cell + _GAP_MM
    width, height = _PAGE_MM
    columns = max(int((width - 2 * _EDGE_MM) // pitch), 1)
    rows = max(int((height - 2 * _EDGE_MM - _RULER_MM) // pitch), 1)
    said = f"{family}, {size:g} mm along the black square: cut along the lines"
    for first in range(0, len(tags), columns * rows):
        shapes: list[str] = []
        for place, (number, label) in enumerate(tags[first : first + columns * rows]):
            left = _EDGE_MM + place % columns * pitch
            top = _EDGE_MM + place // columns * pitch
            shapes += _tag(family, number, label, left, top, cell)
        yield _sheet(
            max(width, pitch + 2 * _EDGE_MM), max(height, pitch + 2 * _EDGE_MM), shapes, said
        )


def _tag(
    family: TagFamily, number: str, label: str, left: float, top: float, cell: float
) -> Iterator[str]:
    cells = tag_cells(family, int(number))
    whole = (len(cells) + 2) * cell
    yield (
        f'<rect x="{left:.3f}" y="{top:.3f}" width="{whole:.3f}" height="{whole:.3f}"'
        ' fill="white" stroke="#bbb" stroke-width="0.1"/>'
    )
    for row, line in enumerate(cells):
        for column, value in enumerate(line):
            if value == 0:
                yield _square(left + (column + 1) * cell, top + (row + 1) * cell, cell)
    yield _text(left, top + whole + 3.5, f"{number} {label}")


def _square(left: float, top: float, side: float) -> str:
    return f'<rect x="{left:.3f}" y="{top:.3f}" width="{side:.3f}" height="{side:.3f}"/>'


def _text(left: float, top: float, text: str) -> str:
    return (
        f'<text x="{left:.2f}" y="{top:.2f}" font-family="sans-serif" font-size="3">'
        f"{escape(text)}</text>"
    )


def _sheet(width: float, height: float, shapes: Sequence[str], said: str) -> str:
    """Return an SVG in millimetres with a ruler of 100 mm at its lower edge."""
    left, down = _EDGE_MM, height - _EDGE_MM / 2
    ruler = [f'<rect x="{left}" y="{down - 1}" width="100" height="0.2"/>']
    for mark in range(0, 101, 10):
        tall = 3 if mark % 50 == 0 else 2
        x = left + mark - 0.1
        ruler.append(f'<rect x="{x:.1f}" y="{down - 1 - tall}" width="0.2" height="{tall}"/>')
    ruler.append(_text(left + 104, down - 1, f"100 mm: print at 100 % and measure. {said}"))
    body = "\n".join([*shapes, *ruler])
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="sheet"'
        f' width="{width:g}mm" height="{height:g}mm" viewBox="0 0 {width:g} {height:g}"'
        f' shape-rendering="crispEdges">\n'
        f'<rect width="{width:g}" height="{height:g}" fill="white"/>\n{body}\n</svg>\n'
    )
