"""The room for the centre of a wheel."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt
from random import Random

import pytest

from pirate_sm.core._geometry.network import (
    Elbow,
    Mitre,
    Network,
    NetworkRun,
    Reducer,
    Straight,
    Tee,
    planar,
)
from pirate_sm.core._geometry.route import Route
from pirate_sm.robot.detectors.room import Room

WHEEL, RADIUS = 0.024, 0.060
FREE = RADIUS - WHEEL
CORNER = (1.0, 0.0, 0.0)


def room_of(*segments) -> Room:
    return Room.of(Route(planar(2 * RADIUS, (Straight(1.0), *segments), section="round")), WHEEL)


@pytest.fixture
def mitre() -> Room:
    return room_of(Mitre(radians(90)), Straight(1.0))


@pytest.fixture
def tee() -> Room:
    runs = {
        "main": NetworkRun(2 * RADIUS, (Straight(1.0),), "entry", "t", "round"),
        "on": NetworkRun(2 * RADIUS, (Straight(1.0),), "t.on", "cap", "round"),
        "branch": NetworkRun(2 * RADIUS, (Straight(1.0),), "t.branch", "exit", "round"),
    }
    routes = {"in": ("main", "branch")}
    network = Network(runs, routes, tees={"t": Tee()}, closed=frozenset({"cap"}))
    return Room.of(Route(network), WHEEL)


@pytest.mark.parametrize("seed", range(10))
def test_in_a_straight_a_wheel_may_come_to_the_wall_and_no_nearer(seed: int) -> None:
    room, chance = room_of(), Random(seed)
    x, aside = chance.uniform(-0.5, 1.5), chance.uniform(-pi, pi)

    def at(away_m: float) -> tuple[float, float, float]:
        return x, away_m * cos(aside), away_m * sin(aside)

    assert room.outside_m(at(chance.uniform(0.0, FREE))) == 0.0
    assert room.outside_m(at(FREE + 0.005)) == pytest.approx(0.005)


def test_the_outer_corner_of_a_mitre_has_room_for_a_wheel(mitre: Room) -> None:
    assert mitre.outside_m((1.0 + FREE - 1e-6, -FREE + 1e-6, 0.0)) == 0.0
    for y in (-FREE, 0.0):  # also a wheel that goes straight on
        assert mitre.outside_m((1.0 + FREE + 0.004, y, 0.0)) == pytest.approx(0.004)


@pytest.mark.parametrize("behind", [False, True])
@pytest.mark.parametrize(
    ("along_m", "aside_m", "outside_m"),
    [(-0.012, FREE - 1e-6, 0.0), (-0.012, FREE + 0.003, 0.003), (-0.05, -FREE + 0.004, 0.0)],
)
def test_the_outer_walls_of_a_mitre_go_on_to_where_they_meet(
    behind: bool, along_m: float, aside_m: float, outside_m: float
) -> None:
    """A place is given as how far it is along one of two pipes and to its outer side."""
    room = room_of(Mitre(radians(45)), Straight(1.0))
    c, s = (cos(pi / 4), sin(pi / 4)) if behind else (-1.0, 0.0)
    outward = (s, -c) if behind else (0.0, -1.0)
    point = (1.0 + along_m * c + aside_m * outward[0], along_m * s + aside_m * outward[1], 0.0)

    assert room.outside_m(point) == pytest.approx(outside_m, abs=1e-9)


def test_a_wheel_beside_the_inner_edge_of_a_mitre_does_not_roll_over_it(mitre: Room) -> None:
    for x, y in ((0.05, 0.03), (-0.03, -0.05)):  # beyond the outer wall of one pipe
        assert mitre.outside_m((1.0 + x, y, 0.0)) == pytest.approx(0.05 - FREE)


def test_a_pipe_ends_where_another_one_goes_on() -> None:
    wide = NetworkRun(2 * RADIUS, (Straight(1.0),), "entry", "step", "round")
    narrow = NetworkRun(2 * RADIUS - 0.01, (Straight(1.0),), "step", "exit", "round")
    network = Network({"wide": wide, "narrow": narrow}, {"": ("wide", "narrow")})
    room = Room.of(Route(network), WHEEL)

    assert room.outside_m((0.9, FREE, 0.0)) == 0.0
    assert room.outside_m((1.1, FREE, 0.0)) == pytest.approx(0.005)


def test_a_wheel_rolls_over_the_inner_edge_of_a_mitre(mitre: Room) -> None:
    edge_x, edge_y = 1.0 - RADIUS, RADIUS
    for angle in (radians(10), radians(45), radians(80)):
        for away_m, inside in ((WHEEL + 1e-6, True), (WHEEL - 0.003, False)):
            point = (edge_x + away_m * sin(angle), edge_y - away_m * cos(angle), 0.0)
            found = mitre.outside_m(point)
            assert found == (0.0 if inside else pytest.approx(0.003))


def test_a_tee_has_room_in_all_its_arms(tee: Room) -> None:
    for point in ((0.8, FREE - 1e-6, 0.0), (1.2, -FREE + 1e-6, 0.0), (1.0, 0.3, FREE - 1e-6)):
        assert tee.outside_m(point) == 0.0
    assert tee.outside_m((1.2, FREE + 0.01, 0.0)) == pytest.approx(0.01)
    assert tee.outside_m((1.0, -FREE - 0.01, 0.0)) == pytest.approx(0.01)
    assert tee.outside_m((2.5, 0.0, 0.0)) == pytest.approx(0.5)  # behind the cap
    assert tee.outside_m((-0.5, 0.0, 0.0)) == 0.0  # before the open end


def test_a_wheel_rolls_over_both_edges_of_a_mouth(tee: Room) -> None:
    away_m = (WHEEL + 1e-6) / sqrt(2)
    for edge_x, towards in ((1.0 - RADIUS, 1.0), (1.0 + RADIUS, -1.0)):
        assert tee.outside_m((edge_x + towards * away_m, RADIUS - away_m, 0.0)) == 0.0
        deeper_m = (WHEEL - 0.003) / sqrt(2)
        point = (edge_x + towards * deeper_m, RADIUS - deeper_m, 0.0)
        assert tee.outside_m(point) == pytest.approx(0.003)


def test_an_elbow_bends_its_room(mitre: Room) -> None:
    room = room_of(Elbow(radians(90), 0.18), Straight(1.0))
    for away_m, outside_m in ((0.18 - FREE, 0.0), (0.18 + FREE, 0.0), (0.18 + FREE + 0.005, 0.005)):
        point = (1.0 + away_m * sin(pi / 4), 0.18 - away_m * cos(pi / 4), 0.0)
        assert room.outside_m(point) == pytest.approx(outside_m, abs=1e-9)


def test_a_reducer_narrows_it() -> None:
    room = room_of(Reducer(0.06, 0.1), Straight(1.0))
    for x, free_m in ((0.9, FREE), (1.03, FREE - 0.005), (1.2, FREE - 0.01)):
        assert room.outside_m((x, free_m - 1e-6, 0.0)) == 0.0
        assert room.outside_m((x, free_m + 0.004, 0.0)) == pytest.approx(0.004, abs=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_near_a_point_it_is_the_same(tee: Room, seed: int) -> None:
    chance = Random(seed)
    middle = (chance.uniform(0.0, 2.0), chance.uniform(-0.1, 1.0), 0.0)
    near = tee.near(middle, 0.3)
    point = tuple(each + chance.uniform(-0.1, 0.1) for each in middle)
    if tee.outside_m(point) < 0.05:
        assert near.outside_m(point) == tee.outside_m(point)


def test_near_a_point_are_the_pipes_within_reach_and_the_edges_between_them(tee: Room) -> None:
    near = tee.near((1.05, 0.5, 0.0), 0.6)
    assert [tube.piece.run for tube in near.tubes] == ["branch", "on", "main"]
    assert set(near.edges) == set(tee.edges)
    far = tee.near((0.2, 0.0, 0.0), 0.3)
    assert [tube.piece.run for tube in far.tubes] == ["main"]
    assert len(far.edges) == 1
    assert tee.near((0.2, 0.5, 0.0), 0.3).edges == ()
