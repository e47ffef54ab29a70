"""Networks in space: fittings, tees, routes there and back, loops."""

from __future__ import annotations

from itertools import pairwise
from math import cos, dist, hypot, isnan, pi, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._geometry.network import (
    Elbow,
    Mitre,
    Network,
    NetworkRun,
    Reducer,
    Segment,
    Straight,
    Tee,
)
from pirate_sm.core._geometry.placement import place
from pirate_sm.core._geometry.route import Route
from pirate_sm.core._geometry.space import DRAWING, dot

QUARTER = pi / 2


def one_run(*segments: Segment) -> Network:
    return Network({"main": NetworkRun(0.12, segments, section="round")}, {"main": ("main",)})


def house(roll: float = 0.0, **runs: NetworkRun) -> Network:
    found = {
        "main": NetworkRun(0.12, (Straight(1.0),), "entry", "t1"),
        "on": NetworkRun(0.12, (Straight(2.0),), "t1.on", "cap"),
        "branch": NetworkRun(0.11, (Straight(0.8),), "t1.branch", "exit"),
    }
    routes = {"in": ("main", "branch"), "past": ("main", "on"), "back": ("branch", "main")}
    return Network(found | runs, routes, tees={"t1": Tee(roll)}, closed=frozenset({"cap"}))


def ends_of(name: str, network: Network) -> tuple[tuple[float, ...], tuple[float, ...]]:
    last = place(network).runs[name][-1].frame_at(place(network).runs[name][-1].ends_m)
    return last.origin, last.ahead


def test_an_elbow_turns_along_its_arc() -> None:
    route = Route(one_run(Straight(1.0), Elbow(QUARTER, 0.18), Straight(0.5)))
    first, elbow, last = route.pieces

    assert elbow.length_m == pytest.approx(0.18 * QUARTER)
    middle = elbow.frame_at(elbow.arc_m + elbow.length_m / 2)
    assert middle.origin == pytest.approx((1.0 + 0.18 * sin(pi / 4), 0.18 * (1 - cos(pi / 4)), 0))
    assert middle.ahead == pytest.approx((cos(pi / 4), sin(pi / 4), 0.0))
    assert last.frame.origin == pytest.approx((1.18, 0.18, 0.0))
    assert last.frame.ahead == pytest.approx((0.0, 1.0, 0.0))
    assert route.joints[0][:5] == pytest.approx(
        (
            "elbow",
            first.ends_m + elbow.length_m / 2,
            elbow.length_m / 2,
            elbow.length_m / 2,
            QUARTER,
        )
    )


@pytest.mark.parametrize(
    ("angle", "roll", "ahead"),
    [
        (QUARTER, 0.0, (0, 1, 0)),
        (-QUARTER, 0.0, (0, -1, 0)),
        (radians(20), 0.0, (cos(radians(20)), sin(radians(20)), 0)),
        (-radians(20), 0.0, (cos(radians(20)), -sin(radians(20)), 0)),
        (QUARTER, QUARTER, (0, 0, -1)),
        (-QUARTER, QUARTER, (0, 0, 1)),
    ],
)
@pytest.mark.parametrize("kind", [Mitre, lambda angle, roll: Elbow(angle, 0.2, roll)])
def test_a_fitting_turns_towards_its_roll(angle, roll, ahead, kind) -> None:
    route = Route(one_run(Straight(1.0), kind(angle, roll), Straight(1.0)))

    assert route.pieces[-1].frame.ahead == pytest.approx(ahead, abs=1e-12)
    (joint,) = route.joints
    assert joint.turn_rad == pytest.approx(abs(angle))
    across = (0.0, ahead[1], ahead[2])
    towards = tuple(each / hypot(*across) for each in across)
    assert route.pieces[0].frame.towards(joint.towards_rad) == pytest.approx(towards, abs=1e-12)


def test_a_reducer_narrows_along_its_cone() -> None:
    route = Route(
        one_run(Straight(1.0), Reducer(0.06, 0.1), Straight(1.0), Reducer(0.0, 0.12), Straight(1.0))
    )

    found = [route.diameter_at(arc) for arc in (0.5, 1.03, 1.5, 2.5)]
    assert found == pytest.approx([0.12, 0.11, 0.1, 0.12])
    assert [(each.kind, each.arc_m, each.behind_m) for each in route.joints] == [
        ("reducer", pytest.approx(1.0), pytest.approx(0.06)),
        ("reducer", pytest.approx(2.06), 0.0),
    ]
    assert all(isnan(each.towards_rad) for each in route.joints)
    assert route.crossings_m == ()


FITTINGS = st.one_of(
    st.builds(Mitre, st.floats(-2.0, 2.0), st.floats(-3.0, 3.0)),
    st.builds(Elbow, st.floats(0.1, 2.0), st.floats(0.1, 0.5), st.floats(-3.0, 3.0)),
    st.builds(Elbow, st.floats(-2.0, -0.1), st.floats(0.1, 0.5), st.floats(-3.0, 3.0)),
    st.builds(Reducer, st.floats(0.01, 0.1), st.floats(0.08, 0.2)),
)


@st.composite
def runs(draw: st.DrawFn) -> tuple[Segment, ...]:
    found: list[Segment] = [Straight(draw(st.floats(0.3, 2.0)))]
    for fitting in draw(st.lists(FITTINGS, max_size=4)):
        found += [fitting, Straight(draw(st.floats(0.3, 2.0)))]
    return tuple(found)


@given(runs(), st.floats(0.0, 1.0))
def test_the_point_at_an_arc_of_any_pipe_leads_back_to_it(parts, share) -> None:
    route = Route(one_run(*parts))
    point = route.frame_at(share * route.length_m).origin

    again = route.arc_of(point)

    assert dist(route.frame_at(again).origin, point) == pytest.approx(0.0, abs=1e-9)


@given(runs())
def test_pieces_of_any_pipe_follow_without_a_gap_and_without_twist(parts) -> None:
    for before, after in pairwise(Route(one_run(*parts)).pieces):
        ends = before.frame_at(before.ends_m)
        assert ends.origin == pytest.approx(after.frame.origin, abs=1e-9)
        assert ends.led_to(after.frame.ahead).side == pytest.approx(after.frame.side, abs=1e-9)


@given(runs(), st.sampled_from(["t1", "t1.on", "t1.branch"]), st.floats(-3.0, 3.0))
def test_a_run_that_ends_at_a_tee_is_where_it_would_be_if_it_began_there(parts, port, roll) -> None:
    others = {
        p: NetworkRun(0.12, (Straight(0.5),), p, f"e{n}")
        for n, p in enumerate(("t1", "t1.on", "t1.branch"))
        if p != port
    }
    for came in (True, False):
        ends = ("far", port) if came else (port, "far")
        network = Network(
            {**others, "x": NetworkRun(0.12, parts, *ends)}, {"x": ("x",)}, tees={"t1": Tee(roll)}
        )
        placed = place(network)
        assert placed.misfits == ()
        pieces = placed.runs["x"]
        tip = pieces[-1].frame_at(pieces[-1].ends_m) if came else pieces[0].frame
        tee = placed.tees["t1"]
        assert tip.origin == pytest.approx(tee.origin, abs=1e-9)
        outward = {"t1": (-1.0, tee.ahead), "t1.on": (1.0, tee.ahead), "t1.branch": (1.0, tee.side)}
        sign, direction = outward[port]
        assert dot(tip.ahead, direction) == pytest.approx(-sign if came else sign)


@pytest.mark.parametrize("roll", [0.0, QUARTER, -1.0, pi])
def test_a_tee_branches_off_towards_its_roll(roll: float) -> None:
    network = house(roll)

    assert ends_of("on", network) == (pytest.approx((3.0, 0, 0)), pytest.approx((1.0, 0, 0)))
    _, ahead = ends_of("branch", network)
    assert ahead == pytest.approx(DRAWING.towards(roll), abs=1e-12)
    into, past = Route(network, "in"), Route(network, "past")
    assert into.joints[0][:5] == pytest.approx(("tee", 1.0, 0.055, 0.06, QUARTER))
    assert past.joints[0][:5] == pytest.approx(("tee", 1.0, 0.06, 0.06, 0.0))
    assert into.crossings_m == (1.0,)
    assert past.crossings_m == ()
    for route in (into, past):
        assert cos(route.joints[0].towards_rad - roll) == pytest.approx(1.0)


def test_a_route_may_pass_runs_from_their_end_to_their_beginning() -> None:
    there, back = Route(house(0.4), "in"), Route(house(0.4), "back")

    assert back.length_m == pytest.approx(there.length_m)
    for arc in (0.1, 0.7, 0.9, 1.5):
        gone, came = there.frame_at(arc), back.frame_at(there.length_m - arc)
        assert gone.origin == pytest.approx(came.origin)
        assert dot(gone.ahead, came.ahead) == pytest.approx(-1.0)
    assert back.pieces[0].frame.origin == pytest.approx(there.frame_at(there.length_m).origin)


@given(runs())
def test_a_run_backwards_meets_the_same_joints(parts) -> None:
    there = Route(
        Network(
            {
                "a": NetworkRun(0.12, (Straight(1.0),), "x", "j"),
                "b": NetworkRun(0.12, parts, "j", "y"),
            },
            {"b": ("a", "b")},
        )
    )
    back = Route(
        Network(
            {
                "a": NetworkRun(0.12, (Straight(1.0),), "x", "j"),
                "b": NetworkRun(0.12, parts, "y", "j"),
            },
            {"b": ("b", "a")},
        )
    )

    turns = [joint.turn_rad for joint in there.joints if joint.turn_rad]
    assert [joint.turn_rad for joint in back.joints if joint.turn_rad] == pytest.approx(turns)
    for route in (there, back):
        for piece in route.pieces:
            _, ahead, side, normal = piece.frame
            assert [dot(ahead, side), dot(side, normal)] == pytest.approx([0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize(
    ("leg_m", "angle", "misfit"),
    [
        (0.5, -QUARTER, ""),
        (0.504, -QUARTER, ""),
        (0.52, -QUARTER, "this misses its junction by 20 mm: seen along the first run it lies "
         "20 mm too far to side A"),
        (0.5, QUARTER, "this misses its junction by 2000 mm"),
        (0.5, -1.54, "this misses its junction by"),
    ],
)  # fmt: skip
def test_a_loop_that_does_not_close_is_a_misfit_at_the_end_of_its_last_run(
    leg_m: float, angle: float, misfit: str
) -> None:
    home = (Straight(leg_m), Mitre(angle), Straight(1.0))
    network = Network(
        {
            "main": NetworkRun(0.12, (Straight(1.0),), "entry", "t1"),
            "ring": NetworkRun(0.12, (Straight(1.0), Mitre(QUARTER), Straight(0.5)), "t1.on", "t2"),
            "stub": NetworkRun(0.12, (Straight(0.5),), "t2.on", "cap"),
            "home": NetworkRun(0.12, home, "t1.branch", "t2.branch"),
        },
        {"main": ("main",)},
        tees={"t1": Tee(), "t2": Tee()},
    )

    misfits = place(network).misfits

    assert len(misfits) == bool(misfit)
    for found in misfits:
        assert (found.run, found.begins) == ("home", False)
        assert found.message.startswith(misfit)


def test_what_nothing_connects_is_a_misfit() -> None:
    lonely = house(lonely=NetworkRun(0.12, (Straight(1.0),), "a", "b"))
    crowded = house(crowded=NetworkRun(0.12, (Straight(1.0),), "t1.on", "b"))

    (one,) = place(lonely).misfits
    (other,) = place(crowded).misfits
    assert (one.run, one.message) == ("lonely", "nothing connects this with the run 'main'")
    assert (other.run, other.begins) == ("crowded", True)
