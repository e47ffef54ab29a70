from __future__ import annotations

from math import radians

import pytest

from pirate_sm.detectors.route import Route
from pirate_sm.model.pipe import Mitre, Pipe, Straight

S_BEND = Pipe(
    diameter=0.12,
    segments=(
        Straight(straight=0.4), Straight(straight=0.6), Mitre(mitre=radians(90)),
        Straight(straight=0.5), Mitre(mitre=radians(-90)), Straight(straight=0.7),
    ),
)  # fmt: skip


def test_crossings_are_where_the_axes_meet() -> None:
    assert Route(S_BEND).crossings_m == pytest.approx((1.0, 1.5))


@pytest.mark.parametrize(
    ("point", "place"),
    [
        ((0.3, 0.03), 0.3),
        ((-0.2, 0.0), -0.2),  # before the beginning the first leg goes on
        ((1.0, 0.2), 1.2),
        ((1.04, 0.2), 1.2),
        ((1.3, 0.5), 1.8),
        ((2.5, 0.5), 3.0),  # so does the last one behind the end
    ],
)
def test_a_point_is_at_the_place_of_the_nearest_axis(point, place) -> None:
    assert Route(S_BEND).place_of(point) == pytest.approx(place)


@pytest.mark.parametrize("place", [0.1, 0.7, 1.1, 1.3, 1.7, 2.2])
def test_a_place_and_its_point_belong_together(place: float) -> None:
    route = Route(S_BEND)
    assert route.place_of(route.leg_at(place).point(place, 0.02)) == pytest.approx(place)
