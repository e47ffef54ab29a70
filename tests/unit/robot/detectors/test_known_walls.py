"""How far a robot is moved by the walls: to the nearest place where no wheel is in one."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan, pi

import pytest

from pirate_sm.core._geometry.network import Mitre, Straight, planar
from pirate_sm.core.geometry import Route, Vector
from pirate_sm.robot.detectors.dead_reckoning import KnownWalls

ROUTE = Route(planar(0.12, (Straight(1.0), Mitre(pi / 2), Straight(1.0)), section="round"))
ROOM_M = 0.035
"""How far the middle of a wheel may be from the axis."""
UNKNOWN = (nan, 0.0, 0.0)


@pytest.fixture
def walls() -> KnownWalls:
    return KnownWalls(ROUTE, 0.025, 0.2)


def at(x: float, depth_m: float) -> Vector:
    """A wheel that is so deep in the wall of the first leg."""
    return x, ROOM_M + depth_m, 0.0


def nowhere(away_m: float) -> Sequence[Vector]:
    return [at(0.5, 0.1)]


@pytest.mark.parametrize(
    ("points", "stays"),
    [
        ([at(0.5, -0.01), at(0.4, 0.0049)], True),
        ([at(0.5, 0.0049), UNKNOWN], True),
        ([UNKNOWN, at(0.5, 0.0051)], False),
        ([at(0.5, -0.01), at(0.4, 0.0051)], False),
    ],
)
def test_a_robot_stays_unless_a_wheel_is_clearly_in_a_wall(
    walls: KnownWalls, points: Sequence[Vector], stays: bool
) -> None:
    away_m = walls.away_m(points, nowhere, 0.1)

    assert away_m == 0.0 if stays else isnan(away_m)


@pytest.mark.parametrize(
    ("free_m", "most_m", "found_m"),
    [
        ((0.003,), 0.03, 0.003),
        ((-0.003,), 0.03, -0.003),
        ((-0.006, 0.006), 0.03, 0.006),
        ((0.009, -0.006), 0.03, -0.006),
        ((0.030,), 0.03, 0.030),
        ((0.033,), 0.03, nan),
        ((0.249,), 1.0, 0.249),
        ((0.252,), 1.0, nan),
    ],
)
def test_it_is_moved_to_the_nearest_place_that_is_free(
    walls: KnownWalls, free_m: Sequence[float], most_m: float, found_m: float
) -> None:
    def laid(away_m: float) -> Sequence[Vector]:
        free = any(abs(away_m - each) < 1e-9 for each in free_m)
        return [UNKNOWN, at(0.5, 0.0029 if free else 0.0031)]

    away_m = walls.away_m([at(0.5, 0.01)], laid, most_m)

    assert away_m == pytest.approx(found_m, nan_ok=True)


def test_pipes_that_another_wheel_reaches_on_the_way_are_known(walls: KnownWalls) -> None:
    """It is 0.2 m ahead of the first known one, and is moved by a quarter of a metre."""
    first = at(1.0 - 0.2 - 0.24, 0.0)

    def laid(away_m: float) -> Sequence[Vector]:
        return [(1.0, 0.1, 0.0) if away_m > 0.24 else at(0.5, 0.1)]

    found_m = walls.away_m([UNKNOWN, first, at(0.7, 0.1)], laid, 0.25)

    assert found_m == pytest.approx(0.243)
