"""Which routes have walls in the plane of the drawing."""

from __future__ import annotations

from math import pi

import pytest

from pirate_sm.core._geometry.network import Elbow, Mitre, Reducer, Segment, Straight, planar
from pirate_sm.core._geometry.route import Route, drawn_walls, walls


def of(*segments: Segment) -> Route:
    return Route(planar(0.12, (Straight(1.0), *segments, Straight(1.0)), section="round"))


def test_a_route_in_the_plane_has_its_walls() -> None:
    route = of(Mitre(pi / 2))
    assert drawn_walls(route) == walls(route)


@pytest.mark.parametrize(
    "fitting", [Mitre(pi / 2, pi / 2), Elbow(pi, 0.2), Elbow(pi / 2, 0.2), Reducer(0.1, 0.1)]
)
def test_a_route_that_leaves_it_or_is_not_of_straights_has_none(fitting: Segment) -> None:
    assert drawn_walls(of(fitting)) == ()
