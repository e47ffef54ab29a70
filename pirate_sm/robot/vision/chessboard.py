"""Chessboards: finding their corners in pictures, and which pictures are of use."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Floats, Gray

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
