"""Where the wheels are by what a camera has seen of the links."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, isnan, nan, radians

import pytest

from pirate_sm.core._model.pipe_runs import Mitre
from pirate_sm.core.events import SeenMark, Sighting
from pirate_sm.core.geometry import DRAWING, ChainInSpace, Pose, inner_corner
from pirate_sm.core.models import Pipe, Straight
from pirate_sm.core.sensing import BodySpec
from pirate_sm.robot.detectors.dead_reckoning import Reckoned
from pirate_sm.robot.detectors.vision_detector import OneMarker, SeenWheels, Tags

BODY = BodySpec((0.10, 0.06, 0.08, 0.11, 0.07), (1,) * 6, (-1, 0, 1, 2, 3, -1), (), 0.02)
BORE_M = 0.12
ROUTE = Pipe(
    diameter=BORE_M,
    segments=(Straight(straight=1.0), Mitre(mitre=radians(90)), Straight(straight=1.0)),
).route()
ORIGIN = inner_corner(ROUTE)
ANGLES = (0.0, -0.6, 0.3, -0.4, 0.2, 0.0)
POINTS = BODY.places(ANGLES, 0, Pose(1.0, 0.03, 0.5))
"""The wheels of a robot whose front comes into the bend."""
LINKS = {f"module {link}": link for link in range(5)}
ALL = range(5)


def marks(links: Sequence[int], off_m: float = 0.0) -> tuple[SeenMark, ...]:
    """The tags of these links, seen next to their places."""
    found = []
    for link in links:
        (ax, ay), (bx, by) = POINTS[link : link + 2]
        middle = (ax + bx) / 2 - ORIGIN[0] + off_m, (ay + by) / 2 - ORIGIN[1] + 2 * off_m
        found.append(SeenMark(f"module {link}", middle, atan2(ay - by, ax - bx)))
    return tuple(found)


def seen(now_s: float, *found: SeenMark) -> Sighting:
    return Sighting(now_s, found, None, 100.0, 0)


@pytest.fixture
def tags() -> Tags:
    """Tags all of which were seen at 10 s."""
    looking = Tags(BODY, ROUTE, LINKS)
    looking.place(seen(10.0, *marks(ALL)), ANGLES)
    return looking


def points_of(found: SeenWheels) -> list[float]:
    return [number for point in found.points for number in point]


FLAT = [number for point in POINTS for number in point]


@pytest.mark.parametrize("link", ALL)
def test_one_tag_and_the_joints_show_every_wheel(tags: Tags, link: int) -> None:
    found = tags.place(seen(10.2, *marks([link])), ANGLES)

    assert points_of(found) == pytest.approx(FLAT)
    assert found.places_m == pytest.approx([ROUTE.arc_of((*point, 0.0)) for point in POINTS])
    assert not found.outside


def test_a_tag_shows_both_wheels_of_its_link_whatever_the_joints_are() -> None:
    found = Tags(BODY, ROUTE, LINKS).place(seen(10.0, *marks([0, 2, 4])), (nan,) * 6)

    assert points_of(found) == pytest.approx(FLAT)


def test_two_tags_show_the_wheel_between_them_in_the_middle(tags: Tags) -> None:
    found = tags.place(seen(10.0, *marks([1]), *marks([2], 0.01)), ANGLES)

    off = [(x - at[0], y - at[1]) for (x, y), at in zip(found.points, POINTS, strict=True)]
    assert off[1] == pytest.approx((0.0, 0.0))
    assert off[2] == pytest.approx((0.005, 0.01))
    assert off[3] == pytest.approx((0.01, 0.02))


@pytest.mark.parametrize(
    ("links", "nearest"),
    [([0, 4], [0, 0, 0, 4, 4, 4]), ([4, 0], [0, 0, 0, 4, 4, 4]), ([0, 3], [0, 0, 0, 3, 3, 3])],
)
def test_a_wheel_without_a_seen_tag_is_placed_by_the_nearest_tag(
    tags: Tags, links: list[int], nearest: list[int]
) -> None:
    shown = [mark for link in links for mark in marks([link], 0.001 * link)]

    found = tags.place(seen(10.0, *shown), ANGLES)

    off_m = [x - at[0] for (x, _), at in zip(found.points, POINTS, strict=True)]
    assert off_m == pytest.approx([0.001 * link for link in nearest])


@pytest.mark.parametrize(
    ("link", "hidden", "unknown"),
    [(0, 2, [3, 4, 5]), (4, 2, [0, 1, 2]), (2, 0, [0]), (2, 4, [5]), (2, 2, [])],
)
def test_belief_in_a_link_without_its_tag_ends_after_a_moment(
    link: int, hidden: int, unknown: list[int]
) -> None:
    tags = Tags(BODY, ROUTE, LINKS)
    tags.place(seen(0.0, *marks(ALL)), ANGLES)
    tags.place(seen(0.2, *marks([each for each in ALL if each != hidden])), ANGLES)
    for at_s, lost in ((0.3, []), (0.31, unknown)):
        found = tags.place(seen(at_s, *marks([link])), ANGLES)

        assert [wheel for wheel, (x, _) in enumerate(found.points) if isnan(x)] == lost
        assert [wheel for wheel, place in enumerate(found.places_m) if isnan(place)] == lost
        assert not found.outside, "an unknown wheel is not outside"


def test_a_link_whose_tag_was_never_seen_is_not_bridged() -> None:
    found = Tags(BODY, ROUTE, LINKS).place(seen(0.0, *marks([0])), ANGLES)

    assert [isnan(place) for place in found.places_m] == [False, False, True, True, True, True]


def test_a_mark_without_a_heading_is_no_tag(tags: Tags) -> None:
    spot = SeenMark("module 0", (0.3, 0.3))

    assert points_of(tags.place(seen(10.0, spot, *marks([1])), ANGLES)) == pytest.approx(FLAT)
    assert all(map(isnan, tags.place(seen(10.0, spot), ANGLES).places_m))
    nothing = tags.place(seen(10.0), ANGLES)
    assert len(nothing.places_m) == len(nothing.points) == 6
    assert all(map(isnan, nothing.places_m))


@pytest.mark.parametrize(("y", "inside"), [(0.119, True), (-0.119, True), (0.12, False)])
def test_a_wheel_a_diameter_beside_the_axis_is_outside_of_the_pipe(y: float, inside: bool) -> None:
    marker = OneMarker(ROUTE, 0)
    marker.reckoned = reckoned((0.5, 0.0), (0.4, 0.0))
    place = 0.45 - ORIGIN[0], y - ORIGIN[1]

    found = marker.place(seen(0.0, SeenMark("any", place)), ANGLES)

    assert found.outside != inside
    assert [isnan(each) for each in found.places_m] == [not inside] * 2


def reckoned(*points: tuple[float, float]) -> Reckoned:
    chain = ChainInSpace(tuple((*point, 0.0) for point in points), DRAWING, DRAWING)
    return Reckoned((0.0,) * len(points), chain, 0.0, 0, {}, 0.0)


@pytest.mark.parametrize("link", ALL)
def test_one_marker_moves_the_reckoned_robot_to_where_it_is_seen(link: int) -> None:
    marker = OneMarker(ROUTE, link)
    marker.reckoned = reckoned(*((x - 0.04, y + 0.02) for x, y in POINTS))

    found = marker.place(seen(0.0, *marks([link]), *marks([link], 0.3)), ANGLES)

    assert points_of(found) == pytest.approx(FLAT)


def test_one_marker_shows_nothing_before_the_robot_is_reckoned_or_where_it_is_not_seen() -> None:
    marker = OneMarker(ROUTE, 2)
    assert all(map(isnan, marker.place(seen(0.0, *marks([2])), ANGLES).places_m))
    marker.reckoned = reckoned(*POINTS)
    assert all(map(isnan, points_of(marker.place(seen(0.0), ANGLES))))
