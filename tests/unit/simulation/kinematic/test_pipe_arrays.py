from __future__ import annotations

import math

import pytest

from pirate_sm.core._geometry.network import Mitre, Straight, planar
from pirate_sm.core.geometry import GRAVITY_M_S2, Route
from pirate_sm.simulation.kinematic.world import leg_rows, wall_rows

RADIUS = 0.06


def one_bend(angle_deg: float, **more: float) -> Route:
    parts = (Straight(1.0), Mitre(math.radians(angle_deg)), Straight(2.0))
    return Route(planar(2 * RADIUS, parts, **more))


def test_the_kernel_takes_a_row_for_each_piece_and_two_for_its_walls() -> None:
    route = one_bend(90)
    assert leg_rows(route)[1, :6] == pytest.approx((1.0, 0.0, 0.0, 1.0, 2.0, 1.0))
    # Side A of the first piece: start, tangent, length, normal into the pipe; the inner corner at
    # its end, the next tangent, and the bisector into the pipe.
    half = math.sqrt(0.5)
    assert wall_rows(route)[0] == pytest.approx(
        (0.0, RADIUS, 1.0, 0.0, 1.0 - RADIUS, 0.0, -1.0, 1.0, 0.0, 1.0, half, -half)
    )
    assert wall_rows(route)[1, 7] == 0.0, "the corner on side B is the outer one"


def test_straights_in_a_row_are_one() -> None:
    assert len(leg_rows(Route(planar(0.1, (Straight(0.5), Straight(0.7)))))) == 1


@pytest.mark.parametrize(
    ("tilt", "uphill", "first", "second"),
    [
        (0, 90, (0, 0, 1), (0, 0, 1)),
        (90, 0, (-1, 0, 0), (0, 1, 0)),  # the first leg goes up
        (90, 90, (0, -1, 0), (-1, 0, 0)),  # the far leg goes up
        (30, 90, (0, -0.5, math.cos(math.pi / 6)), (-0.5, 0, math.cos(math.pi / 6))),
    ],
)
def test_gravity_points_down_whatever_way_the_leg_goes(
    tilt: float, uphill: float, first: tuple[float, ...], second: tuple[float, ...]
) -> None:
    route = one_bend(90, tilt_rad=math.radians(tilt), uphill_rad=math.radians(uphill))
    for row, expected in zip(leg_rows(route), (first, second), strict=True):
        assert row[6:] / GRAVITY_M_S2 == pytest.approx(expected, abs=1e-12)
