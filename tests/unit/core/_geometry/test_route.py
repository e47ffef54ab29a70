from __future__ import annotations

from itertools import pairwise
from math import cos, dist, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._geometry.network import Mitre, Network, NetworkRun, Segment, Straight, planar
from pirate_sm.core._geometry.route import Route
from pirate_sm.core._geometry.space import dot

UP = (0.0, 0.0, -1.0)
S_BEND = Route(
    planar(
        0.12,
        (Straight(0.4), Straight(0.6), Mitre(pi / 2), Straight(0.5), Mitre(-pi / 2), Straight(0.7)),
    )
)
MITRES = st.builds(Mitre, st.floats(-2.0, 2.0), st.sampled_from([0.0, pi / 2, -0.7, pi]))


@st.composite
def segments(draw: st.DrawFn, *, rolled: bool = True) -> tuple[Segment, ...]:
    found: list[Segment] = [Straight(draw(st.floats(0.3, 2.0)))]
    for mitre in draw(st.lists(MITRES, max_size=4)):
        flat = mitre if rolled else Mitre(mitre.angle_rad)
        found += [flat, Straight(draw(st.floats(0.3, 2.0)))]
    return tuple(found)


def route(parts: tuple[Segment, ...]) -> Route:
    return Route(Network({"main": NetworkRun(0.12, parts)}, {"main": ("main",)}, UP))


def test_crossings_are_where_the_axes_meet() -> None:
    assert S_BEND.crossings_m == pytest.approx((1.0, 1.5))
    assert S_BEND.length_m == pytest.approx(2.2)


@pytest.mark.parametrize(
    ("point", "arc"),
    [
        ((0.3, 0.03), 0.3),
        ((-0.2, 0.0), -0.2),  # before the beginning the first piece goes on
        ((1.0, 0.2), 1.2),
        ((1.04, 0.2), 1.2),
        ((1.3, 0.5), 1.8),
        ((2.5, 0.5), 3.0),  # so does the last one behind the end
    ],
)
def test_a_point_is_at_the_place_of_the_nearest_axis(
    point: tuple[float, float], arc: float
) -> None:
    assert S_BEND.arc_of((*point, 0.0)) == pytest.approx(arc)


@pytest.mark.parametrize("arc", [0.1, 0.7, 1.1, 1.3, 1.7, 2.2])
def test_a_place_beside_the_axis_and_its_point_belong_together(arc: float) -> None:
    assert S_BEND.arc_of(S_BEND.piece_at(arc).point(arc, 0.02)) == pytest.approx(arc)


@given(segments(), st.floats(0.0, 1.0))
def test_the_point_at_an_arc_leads_back_to_it(parts: tuple[Segment, ...], share: float) -> None:
    way = route(parts)
    arc = share * way.length_m
    point = way.frame_at(arc).origin

    again = way.arc_of(point)

    # A pipe that runs through itself has two arcs at one point.
    assert dist(way.frame_at(again).origin, point) == pytest.approx(0.0, abs=1e-9)


@given(segments())
def test_each_piece_begins_where_the_one_before_ends(parts: tuple[Segment, ...]) -> None:
    for before, after in pairwise(route(parts).pieces):
        assert before.point(before.ends_m) == pytest.approx(after.frame.origin)
        assert before.ends_m == pytest.approx(after.arc_m)
        assert before.bend is not None
        turned = cos(before.bend.angle_rad)
        assert dot(before.frame.ahead, after.frame.ahead) == pytest.approx(turned)


@given(segments())
def test_frames_stay_orthonormal_through_every_bend(parts: tuple[Segment, ...]) -> None:
    for piece in route(parts).pieces:
        _, ahead, side, normal = piece.frame
        lengths = [dot(each, each) for each in (ahead, side, normal)]
        assert lengths == pytest.approx([1.0] * 3)
        assert [dot(ahead, side), dot(side, normal)] == pytest.approx([0.0] * 2)


@given(segments(rolled=False))
def test_bends_in_one_plane_add_up_their_angles_exactly(parts: tuple[Segment, ...]) -> None:
    x = y = heading = 0.0
    pieces = iter(route(parts).pieces)
    for part in parts:
        if isinstance(part, Mitre):
            heading += part.angle_rad
            continue
        frame = next(pieces).frame
        assert frame.origin == (x, y, 0.0)
        assert frame.ahead == (cos(heading), sin(heading), 0.0)
        assert frame.side == (-sin(heading), cos(heading), 0.0)
        x, y = x + part.length_m * cos(heading), y + part.length_m * sin(heading)


@given(st.floats(-2.0, 2.0))
def test_a_bend_rolled_by_half_a_turn_turns_to_the_other_side(angle: float) -> None:
    rolled, other = (
        route((Straight(1.0), mitre, Straight(1.0))).pieces[1].frame
        for mitre in (Mitre(angle, pi), Mitre(-angle))
    )

    for one, same in zip(rolled, other, strict=True):
        assert one == pytest.approx(same, abs=1e-12)


def test_a_bend_rolled_by_a_quarter_turn_leaves_the_plane() -> None:
    quarter = Mitre(pi / 2, pi / 2)
    _, away, along = route((Straight(1.0), quarter, Straight(2.0), quarter, Straight(1.0))).pieces

    assert away.frame.ahead == pytest.approx((0.0, 0.0, -1.0)), "up, against the normal"
    assert away.frame.side == pytest.approx((0.0, 1.0, 0.0)), "carried along without twist"
    assert along.frame.origin == pytest.approx((1.0, 0.0, -2.0))
    assert along.frame.ahead == pytest.approx((-1.0, 0.0, 0.0))


def test_a_piece_has_walls_all_round_between_its_fittings() -> None:
    first, middle, last = S_BEND.pieces

    assert first.clear_m == pytest.approx((0.0, 0.94))
    assert middle.clear_m == pytest.approx((1.06, 1.44))
    assert last.clear_m == pytest.approx((1.56, 2.2))


def test_a_piece_names_the_first_segment_that_it_is_made_of() -> None:
    assert [piece.segment for piece in S_BEND.pieces] == [0, 3, 5]


NETWORK = Network(
    {
        "main": NetworkRun(0.12, (Straight(1.0), Mitre(pi / 2), Straight(0.5)), ends="step"),
        "house": NetworkRun(0.1, (Straight(0.5), Mitre(-pi / 2), Straight(1.0)), begins="step"),
        "field": NetworkRun(0.1, (Straight(3.0),), begins="ditch"),
    },
    {"home": ("main", "house"), "lost": ("main", "field")},
    UP,
)


def test_a_route_leads_through_several_runs() -> None:
    home = Route(NETWORK, "home")

    assert home.length_m == pytest.approx(3.0)
    assert home.crossings_m == pytest.approx((1.0, 2.0))
    assert home.frame_at(3.0).origin == pytest.approx((2.0, 1.0, 0.0))
    assert [piece.run for piece in home.pieces] == ["main", "main", "house", "house"]
    assert home.piece_at(1.4).diameter_m == 0.12
    assert home.piece_at(1.6).diameter_m == 0.1


def test_runs_of_a_route_must_meet() -> None:
    with pytest.raises(ValueError, match="run 'field' does not begin or end at 'step'"):
        Route(NETWORK, "lost")
