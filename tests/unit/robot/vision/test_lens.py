"""The lens models agree with OpenCV's where those are defined, and are their own inverse."""

from __future__ import annotations

import numpy as np
import pytest

from pirate_sm.robot.camera import Lens
from pirate_sm.robot.vision.opencv import Floats, cv2
from pirate_sm.robot.vision.projection import LensModel, UndistortedView

FISHEYE = Lens(model="fisheye", f=(611.0, 612.8), centre=(971.0, 532.9), k=(-0.012, 0.003, 1e-4, 0))
BROWN = Lens(
    model="brown", f=(800.0, 805.0), centre=(640.0, 360.0), k=(-0.2, 0.05, 1e-3, -2e-3, 0.01)
)


def points(widest_deg: float, count: int = 200) -> np.ndarray:
    chance = np.random.default_rng(1)
    angle = np.radians(widest_deg) * np.sqrt(chance.random(count))
    turn = 2 * np.pi * chance.random(count)
    across = np.sin(angle)
    rays = np.column_stack([across * np.cos(turn), across * np.sin(turn), np.cos(angle)])
    return rays * chance.uniform(0.2, 3.0, count)[:, None]


def test_a_fisheye_projects_as_opencv_does_within_its_half_space() -> None:
    there, model = points(80), LensModel(FISHEYE)
    wanted = cv2.fisheye.projectPoints(
        there[None], np.zeros(3), np.zeros(3), model.matrix, model.coefficients
    )[0]

    assert model.project(there) == pytest.approx(wanted.reshape(-1, 2), abs=1e-6)


def test_brown_projects_as_opencv_does() -> None:
    there, model = points(40), LensModel(BROWN)
    wanted = cv2.projectPoints(there, np.zeros(3), np.zeros(3), model.matrix, model.coefficients)[0]

    assert model.project(there) == pytest.approx(wanted.reshape(-1, 2), abs=1e-6)


@pytest.mark.parametrize(("lens", "widest_deg"), [(FISHEYE, 95), (BROWN, 35)])
def test_rays_are_the_inverse_of_the_projection(lens: Lens, widest_deg: float) -> None:
    there, model = points(widest_deg), LensModel(lens)
    rays = model.rays(model.project(there))

    assert rays == pytest.approx(there / np.linalg.norm(there, axis=1, keepdims=True), abs=1e-6)


def test_what_is_behind_a_flat_picture_is_not_seen() -> None:
    behind = np.array([[0.1, 0.2, -1.0], [0.0, 0.1, 1.0]])

    assert np.isnan(LensModel(BROWN).project(behind)).all(axis=1).tolist() == [True, False]


def test_a_pixel_that_no_ray_reaches_has_none() -> None:
    folding = Lens(model="fisheye", f=(300.0, 300.0), centre=(0.0, 0.0), k=(-0.3, 0, 0, 0))

    rays = LensModel(folding).rays(np.array([[600.0, 0.0], [30.0, 0.0]]))

    assert np.isnan(rays).any(axis=1).tolist() == [True, False]


def pixels_of(view: UndistortedView, rays: Floats) -> Floats:
    """Return where directions are in the view."""
    pixels: Floats = (rays / rays[:, 2:] @ view.matrix.T)[:, :2]
    return pixels


def test_the_view_without_distortion_shows_straight_lines_straight() -> None:
    view = UndistortedView(LensModel(FISHEYE), (1920, 1080))
    line = np.column_stack([np.linspace(-1, 1, 9), np.full(9, 0.3), np.ones(9)])
    pixels = pixels_of(view, line)

    assert pixels[:, 1] == pytest.approx(pixels[0, 1])
    rays = line / np.linalg.norm(line, axis=1, keepdims=True)
    assert view.rays(pixels) == pytest.approx(rays)


def test_the_view_without_distortion_shows_what_the_lens_sees() -> None:
    model = LensModel(FISHEYE)
    frame = np.zeros((1080, 1920, 3), np.uint8)
    ray = np.array([[0.5, 0.2, 1.0]])
    (u, v), view = model.project(ray)[0], UndistortedView(model, (1920, 1080))
    cv2.circle(frame, (round(u), round(v)), 4, (255, 255, 255), -1)

    bright = np.argwhere(view.of(frame)[..., 0] > 128).mean(axis=0)[::-1]

    assert bright == pytest.approx(pixels_of(view, ray)[0], abs=1.0)
