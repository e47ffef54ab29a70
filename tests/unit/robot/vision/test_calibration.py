"""A lens is measured by boards all over the picture; boards that cannot tell it are refused."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.vision_boards import draw_board
from pirate_sm.robot.camera import CameraPose, Lens
from pirate_sm.robot.vision.calibration import LensCalibration, calibrate
from pirate_sm.robot.vision.opencv import Floats, cv2
from pirate_sm.robot.vision.projection import LensModel, View, rotation_of, turn_of
from pirate_sm.robot.vision.targets import Chessboard, find_board, is_another, is_sharp
from tests.unit.robot.vision.rendered_boards import SIZE as RENDERED_SIZE
from tests.unit.robot.vision.rendered_boards import RenderedLens

SIZE = (640, 480)
FISHEYE = Lens(model="fisheye", f=(205.0, 206.0), centre=(323.0, 238.0), k=(-0.012, 0.003, 0, 0))
BROWN = Lens(model="brown", f=(600.0, 603.0), centre=(318.0, 243.0), k=(-0.2, 0.06, 0.001, 0, 0))
BOARD = Chessboard()


def held(lens: LensModel, number: int, tilt_rad: float, distance_m: float, reach: float) -> View:
    """The view of a board that is held into one of twenty parts of the picture."""
    chance = np.random.default_rng(number)
    across, down = number % 5 / 2 - 1, number // 5 / 1.5 - 1
    centre = np.array(lens.lens.centre)
    ray = lens.rays((centre + reach * np.array([220 * across, 160 * down]))[None])[0]
    side = np.cross([0, 1, 0], ray)
    side /= np.linalg.norm(side)
    facing = np.column_stack([side, np.cross(ray, side), ray])
    rotation = facing @ rotation_of(tilt_rad * chance.uniform(-1, 1, 3))
    shift = ray * distance_m - rotation @ np.array([0.1, 0.0625, 0.0])
    at = -rotation.T @ shift
    return View(lens, CameraPose(at=tuple(at), turn=tuple(turn_of(rotation))))


def boards(
    lens: Lens, count: int = 20, tilt_rad: float = 0.5, reach: float = 1.0, noise_px: float = 0.1
) -> dict[str, Floats]:
    model, chance = LensModel(lens), np.random.default_rng(0)
    distance_m = 0.3 if lens.model == "fisheye" else 0.8
    views = [held(model, number, tilt_rad, distance_m, reach) for number in range(count)]
    points = BOARD.points
    return {
        f"board {number}": view.project(points) + chance.normal(0, noise_px, (len(points), 2))
        for number, view in enumerate(views)
    }


@pytest.mark.parametrize(
    "lens", [pytest.param(FISHEYE, marks=pytest.mark.thorough), BROWN], ids=["fisheye", "brown"]
)
def test_the_lens_is_found_again(lens: Lens) -> None:
    result = calibrate(boards(lens), BOARD, SIZE, lens.model)

    assert isinstance(result, LensCalibration)
    assert result.lens.f == pytest.approx(lens.f, rel=5e-3)
    assert result.lens.centre == pytest.approx(lens.centre, abs=3.0)
    assert result.rms_px == pytest.approx(0.14, abs=0.02)  # the noise of both coordinates


LENSES = [
    RenderedLens("fisheye", 60.0, (0.02, 0.0)),
    RenderedLens("fisheye", 100.0, (-0.05, 0.01)),
    RenderedLens("fisheye", 140.0, (-0.02, 0.0)),
    RenderedLens("fisheye", 180.0, (-0.012, 0.003)),
    RenderedLens("fisheye", 200.0, (-0.03, 0.0)),
    RenderedLens("fisheye", 200.0, (0.03, 0.0)),
    RenderedLens("brown", 60.0, (-0.2, 0.06)),
    RenderedLens("brown", 90.0, (-0.1, 0.01)),
    RenderedLens("brown", 120.0, (-0.03, 5e-4), board=0.2),
]


@pytest.mark.thorough
@pytest.mark.parametrize("lens", LENSES, ids=lambda lens: f"{lens.model} {lens.across_deg:.0f} deg")
def test_a_lens_of_any_angle_is_found_in_pictures_that_opencv_did_not_draw(
    lens: RenderedLens,
) -> None:
    found = {str(n): find_board(picture, BOARD) for n, picture in enumerate(lens.pictures())}
    seen = {name: corners for name, corners in found.items() if corners is not None}

    result = calibrate(seen, BOARD, RENDERED_SIZE, lens.model)

    assert isinstance(result, LensCalibration), result
    assert result.rms_px < 0.2
    assert not result.left_out
    assert result.lens.f == pytest.approx([lens.focal_px] * 2, rel=7e-3)
    edge_px = np.array([[2.0, 179.5], [477.0, 179.5]])
    turned_deg = np.degrees(np.arctan2(*LensModel(result.lens).rays(edge_px)[:, [0, 2]].T))
    wanted = np.degrees(np.arctan2(*lens.rays(edge_px[:, 0] - 239.5, np.zeros(2))[:, [0, 2]].T))
    assert turned_deg == pytest.approx(wanted, abs=0.6)


@pytest.mark.thorough
def test_a_board_with_mistaken_corners_is_left_out_by_name() -> None:
    seen = boards(FISHEYE)
    seen["board 3"] = seen["board 3"] + np.random.default_rng(5).normal(0, 4, (54, 2))

    result = calibrate(seen, BOARD, SIZE, "fisheye")

    assert isinstance(result, LensCalibration)
    assert list(result.left_out) == ["board 3"]
    assert result.left_out["board 3"] == pytest.approx(5.0, abs=0.3)
    assert result.lens.f == pytest.approx(FISHEYE.f, rel=5e-3)
    assert result.rms_px == pytest.approx(0.14, abs=0.02)


@pytest.mark.thorough
def test_boards_at_the_edge_are_not_left_out_to_make_a_model_fit() -> None:
    wide = Lens(model="fisheye", f=(170.0, 170.0), centre=(320.0, 240.0), k=(0.02, 0, 0, 0))

    result = calibrate(boards(wide, reach=1.1), BOARD, SIZE, "brown")

    assert "the model brown does not fit this lens" in str(result)


def test_too_few_boards() -> None:
    result = calibrate(boards(FISHEYE, 14), BOARD, SIZE, "fisheye")

    assert str(result).startswith("14 sharp boards of 9 × 6 corners were found, at least 15")


def test_boards_in_the_middle_only() -> None:
    result = calibrate(boards(FISHEYE, reach=0.1), BOARD, SIZE, "fisheye")

    assert "of the 9 parts of the picture" in str(result)


@pytest.mark.thorough
def test_boards_of_one_pose() -> None:
    flat = LensModel(BROWN)
    one = [
        View(flat, CameraPose(at=(0.1 - x, 0.0625 - y, -0.6), turn=(0.0, 0.0, 0.0)))
        for x in np.linspace(-0.2, 0.2, 5)
        for y in np.linspace(-0.15, 0.15, 4)
    ]
    chance = np.random.default_rng(1)
    seen = {
        str(number): view.project(BOARD.points) + chance.normal(0, 0.05, (54, 2))
        for number, view in enumerate(one)
    }

    assert "boards lie at nearly the same angle" in str(calibrate(seen, BOARD, SIZE, "brown"))


@pytest.mark.thorough
def test_corners_that_fit_no_lens_well() -> None:
    result = calibrate(boards(FISHEYE, noise_px=1.0), BOARD, SIZE, "fisheye")

    assert "the corners are off by 1.37 px" in str(result)
    assert "more than 0.5 px" in str(result)


def test_a_board_is_found_where_it_was_drawn() -> None:
    view = held(LensModel(FISHEYE), 7, 0.4, 0.2, 1.0)
    corners = find_board(draw_board(view, BOARD, SIZE), BOARD)

    assert corners is not None
    wanted = view.project(BOARD.points)
    error = min(np.abs(corners - wanted).max(), np.abs(corners[::-1] - wanted).max())
    assert error < 0.5


def test_a_blurred_board_is_not_sharp() -> None:
    view = held(LensModel(FISHEYE), 7, 0.0, 0.15, 1.0)
    sharp = draw_board(view, BOARD, SIZE)
    corners = view.project(BOARD.points)

    assert is_sharp(sharp, corners, BOARD)
    assert not is_sharp(cv2.GaussianBlur(sharp, (0, 0), 4.0), corners, BOARD)


def test_a_picture_without_a_board_has_none() -> None:
    assert find_board(np.full((120, 160), 90, np.uint8), BOARD) is None


def test_the_same_board_again_is_no_other_one_even_if_it_is_turned_round() -> None:
    here = np.array([[100.0, 100.0], [200.0, 100.0], [200.0, 150.0]])

    assert not is_another(here + 5, [here], 640)
    assert not is_another(here[::-1], [here], 640)
    assert is_another(here + 40, [here], 640)
