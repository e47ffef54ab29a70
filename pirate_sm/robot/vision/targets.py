"""Square tags and chessboards: finding them in pictures, and sheets with them to print."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from html import escape
from typing import Any, Final

import numpy as np

from pirate_sm.robot.camera import TagFamily
from pirate_sm.robot.vision.opencv import Floats, Frame, Gray, cv2

# --- tags -----------------------------------------------------------------------------------------


_DICTIONARIES: Final[Mapping[TagFamily, int]] = {
    "aruco_4x4_50": cv2.aruco.DICT_4X4_50,
    "apriltag_36h11": cv2.aruco.DICT_APRILTAG_36h11,
}
_NEAR_PX = 40
_BORDER = 1  # black cells around the code


@dataclass(frozen=True)
class FoundTag:
    """A tag in a frame.

    Attributes:
        number: Its number in its family.
        corners: (4, 2) px: upper left, upper right, lower right, lower left of the tag.
    """

    number: int
    corners: Floats


def tag_cells(family: TagFamily, number: int) -> Gray:
    """Return a tag as one pixel for each cell, 0 or 255, with its black border."""
    cells = _dictionary(family).markerSize + 2 * _BORDER
    picture: Gray = cv2.aruco.generateImageMarker(_dictionary(family), number, cells, None, _BORDER)
    return picture


def tag_corners(middle: tuple[float, float], heading_rad: float, size_m: float) -> Floats:
    """Return the corners of a tag in its plane, (4, 2), in the order of :class:`FoundTag`.

    Args:
        middle: Its middle.
        heading_rad: Direction of its upper edge from its middle, from x to y.
        size_m: Length of its sides.
    """
    ahead = np.array([np.cos(heading_rad), np.sin(heading_rad)]) * size_m / 2
    left = np.array([-ahead[1], ahead[0]])
    return np.array(middle) + np.array([ahead + left, ahead - left, -ahead - left, left - ahead])


def find_tags(gray: Gray, family: TagFamily) -> list[FoundTag]:
    """Return the tags of a family in a frame, in the order of their numbers."""
    corners, numbers, _ = _detector(family).detectMarkers(gray)
    if numbers is None:
        return []
    found = [
        FoundTag(int(number), each.reshape(4, 2).astype(np.float64))
        for number, each in zip(numbers.ravel(), corners, strict=True)
    ]
    return sorted(found, key=lambda tag: tag.number)


def find_tag_near(frame: Frame, family: TagFamily, number: int, corners: Floats) -> FoundTag | None:
    """Return a tag that is near its expected corners, (4, 2) px; None if it is not there.

    It takes a hundredth of the time of searching the whole picture.
    """
    if not np.all(np.isfinite(corners)):
        return None
    left, top = np.maximum(np.floor(corners.min(axis=0)).astype(int) - _NEAR_PX, 0)
    right, bottom = np.maximum(np.ceil(corners.max(axis=0)).astype(int) + _NEAR_PX, 0)
    part = frame[top:bottom, left:right]
    if min(part.shape[:2]) < _NEAR_PX:
        return None
    found = (tag for tag in find_tags(grayed(part), family) if tag.number == number)
    tag = next(found, None)
    return tag and FoundTag(number, tag.corners + np.array([left, top]))


def grayed(frame: Frame) -> Gray:
    """Return a frame without its colours."""
    gray: Gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    return gray


@lru_cache
def _dictionary(family: TagFamily) -> Any:
    return cv2.aruco.getPredefinedDictionary(_DICTIONARIES[family])


@lru_cache
def _detector(family: TagFamily) -> Any:
    parameters = cv2.aruco.DetectorParameters()
    parameters.adaptiveThreshWinSizeMin = 7
    parameters.adaptiveThreshWinSizeMax = 23
    parameters.adaptiveThreshWinSizeStep = 16
    parameters.minMarkerPerimeterRate = 0.015  # of 1920 px: sides of 7 px
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    parameters.cornerRefinementWinSize = 5
    parameters.relativeCornerRefinmentWinSize = 0.5
    return cv2.aruco.ArucoDetector(_dictionary(family), parameters)


# --- chessboards ----------------------------------------------------------------------------------


_BLURRED_PX = 3.5
"""Width of the edges of a blurred board; OpenCV recommends at most 3."""

_STEP = 0.03
"""Of the width of the picture: how far a board has moved when it is another one."""


@dataclass(frozen=True)
class Chessboard:
    """A chessboard as it is printed.

    Attributes:
        inside: How many corners there are inside of it, along its width and its height.
        square_m: Length of the sides of its squares.
    """

    inside: tuple[int, int] = (9, 6)
    square_m: float = 0.025

    @property
    def points(self) -> Floats:
        """Return its corners, (N, 3) in m, in the order of :func:`find_board`."""
        across, down = self.inside
        grid = [(x, y, 0.0) for y in range(down) for x in range(across)]
        return np.array(grid) * self.square_m


def find_board(gray: Gray, board: Chessboard) -> Floats | None:
    """Return the corners of a board in a picture, (N, 2) in px; None if there is none."""
    found, corners = cv2.findChessboardCornersSB(
        gray, board.inside, flags=cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    )
    return corners.reshape(-1, 2).astype(np.float64) if found else None


def is_sharp(gray: Gray, corners: Floats, board: Chessboard) -> bool:
    """Return whether the edges of a found board are sharp."""
    width = cv2.estimateChessboardSharpness(
        gray, board.inside, corners.astype(np.float32).reshape(-1, 1, 2)
    )[0][0]
    return bool(width <= _BLURRED_PX)


def is_another(corners: Floats, before: list[Floats], width: int) -> bool:
    """Return whether a board is elsewhere than all before; a board may be found turned round."""
    return all(
        min(_apart(corners, each), _apart(corners[::-1], each)) > _STEP * width for each in before
    )


def _apart(one: Floats, other: Floats) -> float:
    return float(np.linalg.norm(one - other, axis=1).mean())


# --- sheets to print ------------------------------------------------------------------------------


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
