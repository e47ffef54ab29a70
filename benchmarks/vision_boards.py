"""Calibrates lenses by drawn chessboards; a part of `benchmarks.vision`."""

from __future__ import annotations

import numpy as np

from pirate_sm.model.camera import CameraPose, Lens
from pirate_sm.vision.calibration import calibrate
from pirate_sm.vision.chessboard import Board, find_board
from pirate_sm.vision.lens import LensModel
from pirate_sm.vision.opencv import cv2
from pirate_sm.vision.picture_arrays import Floats
from pirate_sm.vision.plane import View, rotation_of, turn_of
from pirate_sm.vision.synthetic.drawn_board import draw_board

SIZE = (1920, 1080)
TRUE = Lens(model="fisheye", f=(611.0, 612.8), centre=(971.0, 532.9), k=(-0.012, 0.003, 0.0, 0.0))
BOARDS = 20
LARGEST_RMS_PX, LARGEST_ERROR = 0.15, 0.005


def calibrates() -> bool:
    """Print what is measured of a lens by 20 boards; whether the bars are kept."""
    lens, board = LensModel(TRUE), Board()
    seen = _pictures(lens, board)
    good = False
    result = calibrate(seen, board, SIZE, "fisheye")
    if isinstance(result, str):
        print(f"fisheye: {result}")
    else:
        error = max(abs(f / true - 1) for f, true in zip(result.lens.f, TRUE.f, strict=True))
        print(
            f"fisheye: {len(seen)} boards, f off by {100 * error:.2f} %, rms {result.rms_px:.3f} px"
        )
        good = error <= LARGEST_ERROR and result.rms_px <= LARGEST_RMS_PX
    for name, refused in {
        "brown": calibrate(seen, board, SIZE, "brown"),
        "one place": calibrate(_in_one_place(seen), board, SIZE, "fisheye"),
        "one angle": calibrate(_at_one_angle(lens, board), board, SIZE, "fisheye"),
    }.items():
        print(f"{name}: {refused}")
        good &= isinstance(refused, str)
    return good


def _pictures(lens: LensModel, board: Board) -> list[Floats]:
    """The corners that are found in drawn pictures with blur and noise."""
    chance, found = np.random.default_rng(0), []
    for number in range(BOARDS):
        view = _held(lens, number, chance)
        drawn = cv2.GaussianBlur(draw_board(view, board, SIZE), (0, 0), 0.6)
        noisy = drawn + chance.normal(0, 3, drawn.shape)
        corners = find_board(np.clip(noisy, 0, 255).astype(np.uint8), board)
        if corners is not None:
            found.append(corners)
    return found


def _held(lens: LensModel, number: int, chance: np.random.Generator) -> View:
    """The view of a board that is held into one of twenty parts of the picture."""
    offset = np.array([(number % 5 - 2) * 280.0, (number // 5 - 1.5) * 190.0])
    ray = lens.rays((np.array(lens.lens.centre) + offset)[None])[0]
    side = np.cross([0.0, 1.0, 0.0], ray)
    side /= np.linalg.norm(side)
    facing = np.column_stack([side, np.cross(ray, side), ray])
    rotation = facing @ rotation_of(0.5 * chance.uniform(-1, 1, 3))
    middle = np.array([0.1, 0.0625, 0.0])
    at = -rotation.T @ (ray * chance.uniform(0.22, 0.35) - rotation @ middle)
    x, y, z = (float(each) for each in at)
    a, b, c = (float(each) for each in turn_of(rotation))
    return View(lens, CameraPose(at=(x, y, z), turn=(a, b, c)))


def _in_one_place(seen: list[Floats]) -> list[Floats]:
    """The same board again and again, with the noise of finding it."""
    chance = np.random.default_rng(1)
    return [seen[0] + chance.normal(0, 0.05, seen[0].shape) for _ in range(BOARDS)]


def _at_one_angle(lens: LensModel, board: Board) -> list[Floats]:
    """Boards all over the picture that lie in one plane, with the noise of finding them."""
    chance = np.random.default_rng(2)
    views = [
        View(lens, CameraPose(at=(0.1 - x, 0.06 - y, -0.25), turn=(0.0, 0.0, 0.0)))
        for x in np.linspace(-0.4, 0.4, 5)
        for y in np.linspace(-0.15, 0.15, 4)
    ]
    return [view.project(board.points) + chance.normal(0, 0.05, (54, 2)) for view in views]
