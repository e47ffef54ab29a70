"""Measure a lens by pictures of a chessboard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pirate_sm.model.camera import Lens
from pirate_sm.model.camera_source import FrameSize
from pirate_sm.vision.chessboard import Board
from pirate_sm.vision.lens import LensModel
from pirate_sm.vision.opencv import cv2
from pirate_sm.vision.picture_arrays import Floats
from pirate_sm.vision.plane import find_view, rms

FEWEST_BOARDS = 15

LARGEST_RMS_PX: dict[str, float] = {"fisheye": 0.5, "brown": 1.0}
"""What is refused. On synthetic boards of a lens of 180 deg Brown leaves 0.67 px, a fisheye 0.1."""

_LEAST_CELLS, _CELLS = 7, (3, 3)
_LEAST_TILT_DEG = 12.0
_WIDEST_RAD = np.radians(80.0)


@dataclass(frozen=True)
class Calibration:
    """A measured lens.

    Attributes:
        lens: The lens.
        rms_px: How far the corners of the boards are from where they should be.
    """

    lens: Lens
    rms_px: float


def calibrate(
    boards: Sequence[Floats], board: Board, size: FrameSize, model: Literal["fisheye", "brown"]
) -> Calibration | str:
    """Return the lens that fits the boards best, or why these boards are not enough.

    Args:
        boards: The corners of the board in each picture, (N, 2) in px.
        board: The board.
        size: Width and height of the pictures.
        model: The model of the lens.
    """
    refusal = _refusal(boards, board, size)
    if refusal:
        return refusal
    try:
        lens, turns = (
            _fisheye(boards, board, size) if model == "fisheye" else _brown(boards, board, size)
        )
    except cv2.error:
        return "no lens fits these boards: are they flat, of this size, and tilted to each side?"
    tilt_deg = _tilt_deg(turns)
    if tilt_deg < _LEAST_TILT_DEG:
        return (
            f"all boards lie at nearly the same angle, within {tilt_deg:.0f} deg: tilt the board by"
            " 30 deg to each side, else focal length and distance cannot be separated"
        )
    rms_px = _rms_px(LensModel(lens), boards, board)
    limit_px = LARGEST_RMS_PX[model]
    if rms_px == float("inf"):
        return f"the model {model} does not fit this lens at all"
    if rms_px > limit_px:
        return (
            f"the corners are off by {rms_px:.2f} px (rms), more than {limit_px} px: is the board"
            " flat, the camera fixed in focus, and the model right?"
        )
    return Calibration(lens, rms_px)


def _refusal(boards: Sequence[Floats], board: Board, size: FrameSize) -> str:
    """Return why boards are not enough, before anything is computed; empty if they may be."""
    if len(boards) < FEWEST_BOARDS:
        return (
            f"{len(boards)} sharp boards of {board.inside[0]} × {board.inside[1]} corners were"
            f" found, at least {FEWEST_BOARDS} at different places are needed"
        )
    cells = (np.vstack(list(boards)) / np.array(size) * np.array(_CELLS)).astype(int)
    covered = len({(int(x), int(y)) for x, y in cells})
    if covered < _LEAST_CELLS:
        return (
            f"the boards cover {covered} of the 9 parts of the picture: hold the board into every"
            " corner, too, where the distortion is largest"
        )
    return ""


def _fisheye(
    boards: Sequence[Floats], board: Board, size: FrameSize
) -> tuple[Lens, Sequence[Floats]]:
    focal, middle = size[0] / np.pi, np.array(size) / 2  # of a lens that shows 180 deg
    # OpenCV cuts rays with a plane ahead, and fails on those that go sideways.
    ahead = [each for each in boards if _widest(each - middle) < focal * _WIDEST_RAD] or boards
    # OpenCV 5 refuses points of shape (N, 1, ·) here.
    points = [board.points[None]] * len(ahead)
    pixels = [each[None] for each in ahead]
    begin = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-9)
    _, matrix, k, turns, _ = cv2.fisheye.calibrate(
        points, pixels, size, begin, np.zeros(4), flags=flags, criteria=criteria
    )
    return _lens("fisheye", matrix, k), turns


def _widest(offsets: Floats) -> float:
    return float(np.hypot(offsets[:, 0], offsets[:, 1]).max())


def _brown(
    boards: Sequence[Floats], board: Board, size: FrameSize
) -> tuple[Lens, Sequence[Floats]]:
    points = [board.points.astype(np.float32)] * len(boards)
    pixels = [each.astype(np.float32).reshape(-1, 1, 2) for each in boards]
    _, matrix, k, turns, _ = cv2.calibrateCamera(points, pixels, size, None, None)
    return _lens("brown", matrix, k), turns


def _lens(model: Literal["fisheye", "brown"], matrix: Floats, k: Floats) -> Lens:
    (fx, _, cx), (_, fy, cy), _ = matrix.tolist()
    return Lens(model=model, f=(fx, fy), centre=(cx, cy), k=tuple(k.ravel().tolist()))


def _tilt_deg(turns: Sequence[Floats]) -> float:
    """Return the largest angle between a board and the mean of all, deg."""
    normals = np.array([cv2.Rodrigues(np.asarray(turn).reshape(3, 1))[0][:, 2] for turn in turns])
    normals *= np.sign(normals[:, 2:])
    mean = normals.mean(axis=0)
    return float(np.degrees(np.arccos(np.clip(normals @ mean / np.linalg.norm(mean), -1, 1))).max())


def _rms_px(lens: LensModel, boards: Sequence[Floats], board: Board) -> float:
    """Return how far all corners are from where the lens has them, each board at its best place."""
    residuals = []
    for pixels in boards:
        view = find_view(lens, board.points, pixels)
        if view is None:
            return float("inf")
        residuals.append(view.residuals(board.points, pixels))
    return rms(np.concatenate(residuals))
