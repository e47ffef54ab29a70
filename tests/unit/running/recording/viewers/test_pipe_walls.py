"""Pipes in space as they are seen from above, from the side, and unrolled."""

from __future__ import annotations

from math import cos, degrees, pi, sin

import pytest

from pirate_sm.core._geometry.network import Elbow, Mitre, Reducer, Segment, Straight, planar
from pirate_sm.core._geometry.route import Route
from pirate_sm.core._geometry.space import DRAWING, dot
from pirate_sm.running.recording.viewers.pipe_walls import (
    clock_rad,
    outlines,
    plain_tubes,
    seen_in,
    unrolled,
    unrolled_walls,
    upright,
)


def of(*segments: Segment, tilt: float = 0.0, uphill: float = 0.0) -> Route:
    found = (Straight(1.0), *segments, Straight(1.0))
    return Route(planar(0.12, found, tilt, uphill, section="round"))


@pytest.mark.parametrize("up", [(0.0, 0.0, -1.0), (sin(0.4), 0.0, -cos(0.4)), (1.0, 0.0, 0.0)])
def test_the_upright_frame_has_gravity_below(up: tuple[float, float, float]) -> None:
    frame = upright(up)
    assert seen_in(frame, up) == pytest.approx((0.0, 0.0, 1.0))
    assert dot(frame.ahead, frame.side) == pytest.approx(0.0)


def test_side_a_of_a_flat_pipe_is_on_the_right_from_above() -> None:
    x, y, z = seen_in(upright((0.0, 0.0, -1.0)), DRAWING.point(1.0, 0.1))
    assert (x, y, z) == pytest.approx((1.0, -0.1, 0.0))


def test_a_straight_is_seen_as_a_rectangle_and_from_its_end_as_a_circle() -> None:
    tubes = list(plain_tubes(of().placement))
    (side,) = outlines(tubes, (0, 2))
    assert set(side) == {(0.0, -0.06), (2.0, -0.06), (2.0, 0.06), (0.0, 0.06)}
    (end,) = outlines(tubes, (1, 2))
    assert len(end) >= 24
    assert max(y for _, y in end) == pytest.approx(0.06, abs=1e-3)


def test_unrolled_is_how_far_along_and_how_far_to_side_a_of_a_part() -> None:
    route = of(Elbow(pi / 2, 0.2, pi / 2))
    frame = route.frame_at(1.1)
    point = frame._replace(origin=frame.origin).point(0.0, 0.03)
    assert unrolled(route, point, 0.0) == pytest.approx((1.1, 0.03))
    assert unrolled(route, point, pi / 2) == pytest.approx((1.1, 0.0))
    assert unrolled(route, point, pi) == pytest.approx((1.1, -0.03))


def test_unrolled_walls_follow_the_diameter() -> None:
    one, other = unrolled_walls(of(Reducer(0.1, 0.1)))
    assert [x for x, _ in one] == pytest.approx([0.0, 1.0, 1.1, 2.1])
    assert [y for _, y in one] == pytest.approx([0.06, 0.06, 0.05, 0.05])
    assert [(x, -y) for x, y in one] == list(other)


@pytest.mark.parametrize(("roll_deg", "clock_deg"), [(0, 0), (90, 90), (180, 180), (-90, 270)])
def test_a_clock_shows_where_a_side_points_against_gravity(
    roll_deg: float, clock_deg: float
) -> None:
    flat = of(Mitre(pi / 2))
    for arc_m in (0.5, 1.5):
        shown = degrees(clock_rad(flat, arc_m, roll_deg * pi / 180))
        assert shown % 360 == pytest.approx(clock_deg)


def test_a_pipe_rolled_about_its_axis_turns_the_clock() -> None:
    # Behind a mitre that goes up the plane of the pipe is upright: side A of roll 0 is up.
    route = of(tilt=pi / 2, uphill=pi / 2)
    assert degrees(clock_rad(route, 0.5, 0.0)) % 360 == pytest.approx(90)


def test_in_an_upright_pipe_the_clock_shows_the_roll() -> None:
    route = of(tilt=pi / 2, uphill=0.0)
    assert clock_rad(route, 0.5, 0.7) == pytest.approx(0.7)
