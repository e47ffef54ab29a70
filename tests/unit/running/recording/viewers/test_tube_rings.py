"""The walls of pipes as rings of points."""

from __future__ import annotations

from math import dist, hypot, pi

import pytest

from pirate_sm.core._geometry.network import (
    Elbow,
    Mitre,
    Network,
    NetworkRun,
    Reducer,
    Segment,
    Straight,
    Tee,
    planar,
)
from pirate_sm.core._geometry.placement import place
from pirate_sm.core._geometry.route import Route
from pirate_sm.core._geometry.space import between, dot
from pirate_sm.running.recording.viewers.pipe_walls import AROUND, plain_tubes, walls_in_space

R, SMALL = 0.06, 0.04


def of(*segments: Segment) -> Route:
    return Route(planar(2 * R, (Straight(1.0), *segments, Straight(1.0)), section="round"))


def tee(roll: float = 0.0) -> Network:
    runs = {
        "main": NetworkRun(2 * R, (Straight(1.0),), "entry", "t", "round"),
        "past": NetworkRun(2 * R, (Straight(1.0),), "t.on", "cap", "round"),
        "branch": NetworkRun(2 * SMALL, (Straight(1.0),), "t.branch", "exit", "round"),
    }
    return Network(
        runs, {"r": ("main", "branch")}, tees={"t": Tee(roll)}, closed=frozenset({"cap"})
    )


@pytest.mark.parametrize("fitting", [Mitre(pi / 2), Mitre(-1.0, 0.7), Elbow(2.0, 0.2, 0.5)])
def test_every_point_of_a_bent_pipe_is_on_its_wall(fitting: Segment) -> None:
    route = of(fitting)
    for piece, rings in zip(route.pieces, plain_tubes(route.placement), strict=True):
        for point in (point for ring in rings for point in ring):
            beyond_m = piece.beyond_m(point)
            axis = piece.frame_at(piece.arc_m + beyond_m)
            along = dot(between(axis.origin, point), axis.ahead)
            assert (dist(axis.origin, point) ** 2 - along**2) ** 0.5 == pytest.approx(R)


def test_the_two_sides_of_a_mitre_end_in_one_ellipse() -> None:
    one, other = plain_tubes(of(Mitre(1.2, 0.4)).placement)
    for point in one[-1]:
        assert min(dist(point, each) for each in other[0]) < 1e-9


def test_a_reducer_is_a_cone_and_a_step_a_flat_ring() -> None:
    cone = list(plain_tubes(of(Reducer(0.06, 0.1)).placement))[1]
    assert [dist(ring[0], ring[AROUND // 2]) for ring in cone] == pytest.approx([0.12, 0.1])
    first, step, behind = plain_tubes(of(Reducer(0.0, 0.1)).placement)
    assert max(map(dist, step[0], first[-1])) < 1e-9
    assert dist(step[-1][0], behind[0][0]) < 1e-9


@pytest.mark.parametrize("roll", [0.0, 1.0, -pi / 2])
def test_the_mouth_of_a_tee_is_on_both_of_its_pipes(roll: float) -> None:
    network = tee(roll)
    placement = place(network)
    frame = placement.tees["t"]
    main, past, cap, branch, collar = walls_in_space(network, placement)
    for point in (*branch[0], *collar[0]):
        x, y, z = (dot(between(frame.origin, point), axis) for axis in frame[1:])
        assert hypot(y, z) == pytest.approx(R)
        assert hypot(x, z) == pytest.approx(SMALL)
        assert y > 0
    # The collar takes the place of the run between its ends.
    ends = [dot(between(frame.origin, point), frame.ahead) for point in (main[-1][0], past[0][0])]
    assert ends == pytest.approx([-1.25 * SMALL, 1.25 * SMALL])
    edge = [dot(between(frame.origin, point), frame.ahead) for point in collar[-1]]
    assert (min(edge), max(edge)) == pytest.approx(ends)
    assert set(cap[-1]) == {(2.0, 0.0, 0.0)}


def test_a_branch_that_is_placed_from_its_far_end_has_the_same_mouth() -> None:
    forth = tee()
    back = NetworkRun(2 * SMALL, (Straight(1.0),), "exit", "t.branch", "round")
    turned = Network({**forth.runs, "branch": back}, {"r": ("branch", "past")}, tees=forth.tees)
    one = {tuple(round(x, 9) for x in p) for p in [*walls_in_space(forth, place(forth))][3][0]}
    other = {tuple(round(x, 9) for x in p) for p in [*walls_in_space(turned, place(turned))][2][-1]}
    for point in other:
        assert min(dist(point, each) for each in one) < 1e-6
