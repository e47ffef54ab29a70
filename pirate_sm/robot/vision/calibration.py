"""Measure a lens by pictures of a chessboard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from pirate_sm.core.camera import FrameSize, Lens
from pirate_sm.robot.vision.bundle import adjust, guess_lens
from pirate_sm.robot.vision.chessboard import Chessboard
from pirate_sm.robot.vision.lens import LensModel
from pirate_sm.robot.vision.picture_arrays import Floats
from pirate_sm.robot.vision.plane import find_pose, pose_errors, rms, rotation_of

FEWEST_BOARDS = 15

LARGEST_RMS_PX: dict[str, float] = {"fisheye": 0.5, "brown": 1.0}
"""What is refused. On synthetic boards of a lens of 180 deg Brown leaves 0.67 px, a fisheye 0.1."""

_LEAST_CELLS, _CELLS = 7, (3, 3)
_LEAST_TILT_DEG = 12.0

_LEAST_USED = 0.8
"""Share of the boards that the lens must fit; below it is the lens or its model that is wrong."""

_ROUNDS = 2
"""A board without a place in the first guess, or with its mirror image, finds it in the second."""

_FAR_OFF = 3.0
"""A board is left out that is off by more than this many times the median of all, and by more than
the largest rms: pictures in which the board was moved or bent, or its corners were mistaken."""


@dataclass(frozen=True)
class LensCalibration:
    """A measured lens.

    Attributes:
        lens: The lens.
        rms_px: How far the corners of the boards are from where they should be.
        left_out: The boards that were not used, by name, and how far each is off, px.
    """

    lens: Lens
    rms_px: float
    left_out: dict[str, float]


class _Placed(NamedTuple):
    """A board at its best place for a lens; ``rms_px`` is infinite if there is none."""

    pose: Floats
    rms_px: float


def calibrate(
    named: Mapping[str, Floats],
    board: Chessboard,
    size: FrameSize,
    model: Literal["fisheye", "brown"],
) -> LensCalibration | str:
    """Return the lens that fits the boards best, or why these boards are not enough.

    Args:
        named: The corners of the board in each picture, (N, 2) in px, by the picture's name.
        board: The board.
        size: Width and height of the pictures.
        model: The model of the lens.
    """
    boards = list(named.values())
    refusal = _refusal(boards, board, size)
    if refusal:
        return refusal
    lens, placed, used = _fitted(boards, board, size, model)
    off_px = {name: each.rms_px for name, each in zip(named, placed, strict=True)}
    unseen = [name for name, each in off_px.items() if each == float("inf")]
    if unseen:
        return (
            f"the model {model} does not fit this lens: one of this model would not show the board"
            f" where it is seen in {', '.join(unseen)}"
        )
    limit_px = LARGEST_RMS_PX[model]
    rms_px = float(np.sqrt(np.mean([placed[number].rms_px ** 2 for number in used])))
    if rms_px > limit_px:
        return (
            f"the corners are off by {rms_px:.2f} px (rms), more than {limit_px} px: is the board"
            " flat, the camera fixed in focus, and the model right?"
        )
    left_out = {name: px for n, (name, px) in enumerate(off_px.items()) if n not in used}
    refusal = _refusal([boards[number] for number in used], board, size)
    if refusal:
        return f"without {', '.join(left_out)}, whose corners fit no such lens, {refusal}"
    tilt_deg = _tilt_deg([placed[number].pose for number in used])
    if tilt_deg < _LEAST_TILT_DEG:
        return (
            f"all boards lie at nearly the same angle, within {tilt_deg:.0f} deg: tilt the board by"
            " 30 deg to each side, else focal length and distance cannot be separated"
        )
    return LensCalibration(lens.lens, rms_px, left_out)


def _fitted(
    boards: Sequence[Floats], board: Chessboard, size: FrameSize, model: Literal["fisheye", "brown"]
) -> tuple[LensModel, list[_Placed], list[int]]:
    """Return the lens, each board's place in it, and the numbers of the boards that were used."""
    lens = guess_lens(model, boards, board.points, size)
    used = list(range(len(boards)))
    while True:
        for _ in range(_ROUNDS):
            lens, placed = _adjusted(lens, boards, board, used)
        off_px = np.array([placed[number].rms_px for number in used])
        far_px = max(LARGEST_RMS_PX[model], _FAR_OFF * float(np.median(off_px)))
        off_px[np.isinf(off_px)] = 0.0  # a board that the lens cannot show speaks against the lens
        if off_px.max() <= far_px or len(used) <= _LEAST_USED * len(boards):
            return lens, placed, used
        used.pop(int(np.argmax(off_px)))  # one only: the others are off because of it


def _adjusted(
    lens: LensModel, boards: Sequence[Floats], board: Chessboard, used: Sequence[int]
) -> tuple[LensModel, list[_Placed]]:
    """Return a better lens, and the place of each board in it."""
    placed = _placed(lens, boards, board)
    begun = [number for number in used if np.isfinite(placed[number].rms_px)]
    if not begun:
        return lens, placed
    poses = [placed[number].pose for number in begun]
    better = adjust(lens, poses, board.points, [boards[number] for number in begun])
    return better, _placed(better, boards, board)


def _placed(lens: LensModel, boards: Sequence[Floats], board: Chessboard) -> list[_Placed]:
    found = []
    for pixels in boards:
        pose = find_pose(lens, board.points, pixels)
        if pose is None:
            found.append(_Placed(np.zeros(6), float("inf")))
            continue
        across, down = pose_errors(lens, pose, board.points, pixels).reshape(-1, 2).T
        found.append(_Placed(pose, rms(np.hypot(across, down))))
    return found


def _refusal(boards: Sequence[Floats], board: Chessboard, size: FrameSize) -> str:
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


def _tilt_deg(poses: Sequence[Floats]) -> float:
    """Return the largest angle between a board and the mean of all, deg."""
    normals = np.array([rotation_of(pose[:3])[:, 2] for pose in poses])
    normals *= np.sign(normals[:, 2:])
    mean = normals.mean(axis=0)
    return float(np.degrees(np.arccos(np.clip(normals @ mean / np.linalg.norm(mean), -1, 1))).max())
