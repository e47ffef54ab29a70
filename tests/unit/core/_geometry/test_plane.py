from __future__ import annotations

from math import hypot, pi, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._geometry.network import Mitre, Segment, Straight, planar
from pirate_sm.core._geometry.route import Route, crossing, inner_corner, turned, walls
from pirate_sm.views.showing.picture import nearest_on

RADIUS = 0.06


def one_bend(angle_deg: float) -> Route:
    return Route(planar(2 * RADIUS, (Straight(1.0), Mitre(radians(angle_deg)), Straight(2.0))))


def test_a_positive_mitre_has_its_inner_corner_on_side_a() -> None:
    side_a, side_b = walls(one_bend(90))

    assert side_a[1] == pytest.approx((1.0 - RADIUS, RADIUS))
    assert side_b[1] == pytest.approx((1.0 + RADIUS, -RADIUS))
    assert side_a[2] == pytest.approx((1.0 - RADIUS, 2.0))


def test_a_negative_mitre_is_the_mirror_image() -> None:
    for (x, y), mirrored in zip(walls(one_bend(-60))[1], walls(one_bend(60))[0], strict=True):
        assert (x, -y) == pytest.approx(mirrored)


@given(st.floats(-119, 119).filter(lambda angle: abs(angle) > 1))
def test_walls_are_as_far_from_the_centre_line_everywhere(angle_deg: float) -> None:
    route = one_bend(angle_deg)
    for number, piece in enumerate(route.pieces):
        (x0, y0, _), (tx, ty, _) = piece.frame.origin, piece.frame.ahead
        for wall, side in zip(walls(route), (1, -1), strict=True):
            for x, y in wall[number : number + 2]:
                across = (y - y0) * tx - (x - x0) * ty
                assert across == pytest.approx(side * RADIUS)


RIGHT, LEFT = Mitre(pi / 2), Mitre(-pi / 2)


@pytest.mark.parametrize(
    ("parts", "pair"),
    [
        ((Straight(1), RIGHT, Straight(1), RIGHT, Straight(1)), None),
        ((Straight(1), RIGHT, Straight(1), RIGHT, Straight(1), RIGHT, Straight(0.8)), None),
        ((Straight(1), RIGHT, Straight(1), RIGHT, Straight(0.5), RIGHT, Straight(2)), (0, 3)),
        ((Straight(1), RIGHT, Straight(0.1), RIGHT, Straight(1)), (0, 2)),
        ((Straight(1), RIGHT, Straight(0.2), LEFT, Straight(1)), None),
    ],
)
def test_a_pipe_that_runs_through_itself_is_found(
    parts: tuple[Segment, ...], pair: tuple[int, int] | None
) -> None:
    route = Route(planar(0.12, parts))

    found = crossing(route)

    assert (found and tuple(map(route.pieces.index, found))) == pair


@pytest.mark.parametrize(
    ("place", "away", "near"),
    [
        ((0.5, 0.3), 0.3, (0.5, 0.0)),
        ((-3.0, -4.0), 5.0, (0.0, 0.0)),
        ((1.2, 1.0), 0.2, (1.0, 1.0)),
        ((2.0, 3.0), 2**0.5, (1.0, 2.0)),
    ],
)
def test_the_nearest_point_of_a_line_of_corners(
    place: tuple[float, float], away: float, near: tuple[float, float]
) -> None:
    found = nearest_on([(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)], place)

    assert found[0] == pytest.approx(away)
    assert found[1] == pytest.approx(near)


@given(st.floats(-10, 10), st.floats(-10, 10), st.floats(-7, 7))
def test_turning_a_place_keeps_its_distance(x: float, y: float, angle: float) -> None:
    there = turned((x, y), angle)

    assert hypot(*there) == pytest.approx(hypot(x, y))
    assert turned(there, -angle) == pytest.approx((x, y), abs=1e-9)


def test_places_turn_from_x_to_y() -> None:
    assert turned((1.0, 0.0), pi / 2) == pytest.approx((0.0, 1.0))


@pytest.mark.parametrize(
    ("mitre_deg", "corner"), [(90.0, (0.94, 0.06)), (-90.0, (0.94, -0.06)), (None, (0.0, 0.06))]
)
def test_the_origin_of_a_setup_is_the_inner_corner(
    mitre_deg: float | None, corner: tuple[float, float]
) -> None:
    bend: tuple[Segment, ...] = ()
    if mitre_deg is not None:
        bend = (Mitre(radians(mitre_deg)), Straight(1.0))
    route = Route(planar(0.12, (Straight(1.0), *bend)))

    assert inner_corner(route) == pytest.approx(corner)
