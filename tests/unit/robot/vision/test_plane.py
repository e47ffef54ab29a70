"""The place of the camera is found from known points; its rays meet planes where they should."""

from __future__ import annotations

import numpy as np
import pytest

from pirate_sm.robot.camera import CameraPose, Lens
from pirate_sm.robot.vision.projection import (
    LensModel,
    View,
    find_view,
    raised,
    rms,
    rotation_of,
    turn_of,
)

LENS = LensModel(
    Lens(model="fisheye", f=(611.0, 612.8), centre=(971.0, 532.9), k=(-0.012, 0.003, 0.0, 0.0))
)
VIEW = View(LENS, CameraPose(at=(-0.2, 0.2, 0.55), turn=(2.9, 1.2, 0.05)))
POINTS = np.array(
    [(x, y, z) for z in (0.0, 0.04) for x, y in ((-0.6, 0), (-0.4, -0.2), (0.2, 0.1), (-0.1, 0.6))]
)


def test_the_pose_is_found_again_from_eight_points() -> None:
    found = find_view(LENS, POINTS, VIEW.project(POINTS))

    assert found is not None
    assert found.pose.at == pytest.approx(VIEW.pose.at, abs=1e-7)
    assert found.rotation == pytest.approx(VIEW.rotation, abs=1e-7)


def test_points_that_are_off_by_a_millimetre_leave_places_right_to_a_few() -> None:
    chance = np.random.default_rng(3)
    places = np.column_stack([chance.uniform(-0.6, 0.0, 50), chance.uniform(-0.1, 0.5, 50)])
    pixels = VIEW.project(raised(places, 0.075))
    worst = []
    for _ in range(20):
        wrong = POINTS + chance.uniform(-1e-3, 1e-3, POINTS.shape)
        found = find_view(LENS, wrong, VIEW.project(POINTS))
        assert found is not None
        worst.append(np.abs(found.on_plane(pixels, 0.075) - places).max())

    assert np.mean(worst) < 3.5e-3  # the worst of shared/design: 3.5 mm


def test_exchanged_points_leave_a_large_residual() -> None:
    pixels = VIEW.project(POINTS)
    pixels[[0, 3]] = pixels[[3, 0]]
    found = find_view(LENS, POINTS, pixels)

    assert found is None or rms(found.residuals(POINTS, pixels)) > 30


def test_three_points_are_too_few() -> None:
    assert find_view(LENS, POINTS[:3], VIEW.project(POINTS[:3])) is None


def test_a_place_is_found_again_at_its_height_and_beside_it_at_another() -> None:
    place = np.array([[-0.4, 0.1]])
    pixels = VIEW.project(raised(place, 0.075))

    assert VIEW.on_plane(pixels, 0.075) == pytest.approx(place)
    assert np.linalg.norm(VIEW.on_plane(pixels, 0.0) - place) > 0.02


def test_a_ray_that_points_away_from_the_plane_meets_nothing() -> None:
    up = View(LENS, CameraPose(at=(0.0, 0.0, 0.5), turn=(0.0, 0.0, 0.0)))

    assert np.isnan(up.on_plane(np.array([[971.0, 532.9]]), 0.0)).all()


def test_the_scale_is_that_of_the_focal_length_below_the_camera() -> None:
    below = View(LENS, CameraPose(at=(0.0, 0.0, 0.5), turn=(np.pi, 0.0, 0.0)))

    assert below.scale(np.array([[0.0, 0.0]]), 0.1) == pytest.approx(
        np.sqrt(611.0 * 612.8) / 0.4, rel=1e-4
    )


def test_a_rotation_and_its_axis_are_the_same() -> None:
    turn = np.array([0.3, -1.2, 0.5])

    assert turn_of(rotation_of(turn)) == pytest.approx(turn)


def test_a_point_that_is_not_seen_fits_nowhere() -> None:
    assert rms(np.array([1.0, np.nan])) == float("inf")
    assert rms(np.array([3.0, 4.0])) == pytest.approx(np.sqrt(12.5))


@pytest.mark.parametrize(
    "points", [[(x / 10, 0.1, 0.0) for x in range(6)], [(0.1, 0.1, 0.0)] * 6], ids=["line", "point"]
)
def test_points_in_one_line_or_place_tell_no_pose(points: list[tuple[float, float, float]]) -> None:
    there = np.array(points)

    assert find_view(LENS, there, VIEW.project(there)) is None
