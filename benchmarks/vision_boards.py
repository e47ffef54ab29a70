"""Calibrates lenses by drawn chessboards; a part of `benchmarks.vision`."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pirate_sm.robot.camera import CameraPose, FrameSize, Lens
from pirate_sm.robot.vision.calibration import calibrate
from pirate_sm.robot.vision.opencv import Floats, Gray, cv2
from pirate_sm.robot.vision.projection import LensModel, View, rotation_of, turn_of
from pirate_sm.robot.vision.targets import Chessboard, find_board

SIZE = (1920, 1080)
TRUE = Lens(model="fisheye", f=(611.0, 612.8), centre=(971.0, 532.9), k=(-0.012, 0.003, 0.0, 0.0))
BOARDS = 20
LARGEST_RMS_PX, LARGEST_ERROR = 0.15, 0.005


_DARK, _BRIGHT, _ROOM = 35.0, 215.0, 90.0


def calibrates() -> bool:
    """Print what is measured of a lens by 20 boards; whether the bars are kept."""
    lens, board = LensModel(TRUE), Chessboard()
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
        "one place": calibrate(_in_one_place(next(iter(seen.values()))), board, SIZE, "fisheye"),
        "one angle": calibrate(_at_one_angle(lens, board), board, SIZE, "fisheye"),
    }.items():
        print(f"{name}: {refused}")
        good &= isinstance(refused, str)
    return good


def _pictures(lens: LensModel, board: Chessboard) -> dict[str, Floats]:
    """The corners that are found in drawn pictures with blur and noise."""
    chance, found = np.random.default_rng(0), {}
    for number in range(BOARDS):
        view = _held(lens, number, chance)
        drawn = cv2.GaussianBlur(draw_board(view, board, SIZE), (0, 0), 0.6)
        noisy = drawn + chance.normal(0, 3, drawn.shape)
        corners = find_board(np.clip(noisy, 0, 255).astype(np.uint8), board)
        if corners is not None:
            found[f"board {number}"] = corners
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


def _in_one_place(one: Floats) -> dict[str, Floats]:
    """The same board again and again, with the noise of finding it."""
    chance = np.random.default_rng(1)
    return {f"board {n}": one + chance.normal(0, 0.05, one.shape) for n in range(BOARDS)}


def _at_one_angle(lens: LensModel, board: Chessboard) -> dict[str, Floats]:
    """Boards all over the picture that lie in one plane, with the noise of finding them."""
    chance = np.random.default_rng(2)
    views = [
        View(lens, CameraPose(at=(0.1 - x, 0.06 - y, -0.25), turn=(0.0, 0.0, 0.0)))
        for x in np.linspace(-0.4, 0.4, 5)
        for y in np.linspace(-0.15, 0.15, 4)
    ]
    return {
        f"board {number}": view.project(board.points) + chance.normal(0, 0.05, (54, 2))
        for number, view in enumerate(views)
    }


def draw_board(view: View, board: Chessboard, size: FrameSize) -> Gray:
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
