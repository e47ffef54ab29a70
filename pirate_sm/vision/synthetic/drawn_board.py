"""Draw a chessboard through a lens."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pirate_sm.model.camera_source import FrameSize
from pirate_sm.vision.chessboard import Board
from pirate_sm.vision.lens import LensModel
from pirate_sm.vision.picture_arrays import Floats, Gray
from pirate_sm.vision.plane import View

_DARK, _BRIGHT, _ROOM = 35.0, 215.0, 90.0


def draw_board(view: View, board: Board, size: FrameSize) -> Gray:
    """Return a picture of a board that lies in the plane z = 0 of the view.

    The ray of each pixel is cut with the plane, so that there is no error of drawing: the value is
    the share of white over the pixel's own width.
    """
    width, height = size
    places = view.cut(_rays(view.lens, size), 0.0)
    squares = (places / board.square_m).reshape(height, width, 2)
    # Corners inside begin at 0; around them are the outer squares and a white margin.
    columns, rows = board.inside
    u, v = squares[..., 0], squares[..., 1]
    pattern = _wave(u) * _wave(v)
    value = _DARK + (_BRIGHT - _DARK) * (0.5 - 0.5 * pattern)
    on_squares = (np.abs(u - (columns - 1) / 2) < (columns + 1) / 2) & (
        np.abs(v - (rows - 1) / 2) < (rows + 1) / 2
    )
    on_paper = (np.abs(u - (columns - 1) / 2) < (columns + 3) / 2) & (
        np.abs(v - (rows - 1) / 2) < (rows + 3) / 2
    )
    value = np.where(on_squares, value, np.where(on_paper, _BRIGHT, _ROOM))
    return np.clip(np.round(np.nan_to_num(value, nan=_ROOM)), 0, 255).astype(np.uint8)


@lru_cache(maxsize=1)
def _rays(lens: LensModel, size: FrameSize) -> Floats:
    """Return the ray of each pixel; it is the same in all pictures of a lens."""
    width, height = size
    across, down = np.meshgrid(np.arange(width), np.arange(height))
    return lens.rays(np.column_stack([across.ravel(), down.ravel()]).astype(np.float64))


def _wave(squares: Floats) -> Floats:
    """Return +1 and -1 for every second square, smooth over one pixel at its edges."""
    step = np.maximum(np.abs(np.gradient(squares, axis=1)), np.abs(np.gradient(squares, axis=0)))
    edge = np.abs((squares + 0.5) % 2 - 1) - 0.5  # distance from the nearest edge, in squares
    smooth: Floats = np.clip(2 * edge / np.maximum(step, 1e-9), -1.0, 1.0)
    return smooth
