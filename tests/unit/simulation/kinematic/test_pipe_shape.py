"""The walls that the kernel sees are those of the pipes: compared with points of their surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest

from pirate_sm.core._geometry.network import (
    Elbow,
    Mitre,
    NetworkRun,
    Reducer,
    Straight,
    Tee,
    planar,
)
from pirate_sm.core.geometry import Network, Piece, Route
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.kinematic.space import columns, walls
from pirate_sm.simulation.kinematic.space.pipe_shape import PipeShape, shape_of

Q = math.pi / 2
STEP_M = 0.002


def line(*segments: object, diameter_m: float = 0.12) -> Network:
    return planar(diameter_m, segments, section="round")


def tee(branch_m: float = 0.12, roll_rad: float = 0.0) -> Network:
    runs = {
        "main": NetworkRun(0.12, (Straight(0.3),), "entry", "t", "round"),
        "on": NetworkRun(0.12, (Straight(0.3),), "t.on", "cap", "round"),
        "branch": NetworkRun(branch_m, (Straight(0.3),), "t.branch", "exit", "round"),
    }
    ways = {"in": ("main", "branch")}
    return Network(runs, ways, tees={"t": Tee(roll_rad)}, closed=frozenset({"cap"}))


NETWORKS = {
    "mitre": line(Straight(0.3), Mitre(Q), Straight(0.3)),
    "flat mitre, rolled": line(Straight(0.3), Mitre(0.8, 1.0), Straight(0.3)),
    "elbow": line(Straight(0.2), Elbow(Q, 0.18), Straight(0.2)),
    "elbow the other way, rolled": line(Straight(0.2), Elbow(-Q, 0.1, 0.7), Straight(0.2)),
    "narrowing": line(Straight(0.2), Reducer(0.06, 0.1), Straight(0.2)),
    "widening": line(Straight(0.2), Reducer(0.03, 0.12), Straight(0.2), diameter_m=0.1),
    "step down": line(Straight(0.2), Reducer(0.0, 0.1), Straight(0.2)),
    "step up": line(Straight(0.2), Reducer(0.0, 0.12), Straight(0.2), diameter_m=0.1),
    "tee": tee(),
    "tee with a narrow branch, rolled": tee(0.1, 0.9),
}


def across(piece: Piece, point: Floats) -> tuple[float, float, Floats]:
    """How far a point is along a piece, from its axis, and the axis' place there."""
    along = piece.beyond_m(tuple(point))
    axis = np.array(piece.frame_at(piece.arc_m + along).origin)
    return along, float(np.linalg.norm(point - axis)), axis


def holds(pieces: list[Piece], number: int, point: Floats, by_m: float = 0.0) -> bool:
    """Whether a point is inside a piece, ``by_m`` from its walls and from the cut of a mitre."""
    piece = pieces[number]
    along, off, _ = across(piece, point)
    if off > piece.diameter_at(piece.arc_m + along) / 2 - by_m:
        return False
    begins = number > 0 and pieces[number - 1].bend and pieces[number - 1].run == piece.run
    if (
        begins
        and (point - piece.frame.origin)
        @ (np.array(piece.frame.ahead) + pieces[number - 1].frame.ahead)
        < by_m
    ):
        return False
    if not begins and along < by_m:
        return False
    if piece.bend is None:
        return along <= piece.length_m - by_m
    after = pieces[number + 1].frame
    ahead = np.array(piece.frame.ahead) + after.ahead
    return bool((point - after.origin) @ ahead <= -by_m)


def surface(pieces: list[Piece]) -> Iterator[Floats]:
    """Points of the walls: of each piece those that are not inside another one."""
    for number, piece in enumerate(pieces):
        more = piece.diameter_m
        for s in np.arange(-more, piece.length_m + more, STEP_M):
            radius = piece.diameter_at(piece.arc_m + s) / 2
            frame = piece.frame_at(piece.arc_m + s)
            for angle in np.arange(0.0, 2 * math.pi, STEP_M / radius):
                out = np.cos(angle) * np.array(frame.side) + np.sin(angle) * np.array(frame.normal)
                own = np.array(frame.origin) + (radius - 1e-9) * out
                inside = [holds(pieces, n, own, 1e-6) for n in range(len(pieces)) if n != number]
                if holds(pieces, number, own) and not any(inside):
                    yield own
    for before, after in pairwise(pieces):
        wide, narrow = sorted((before.ends_with_m / 2, after.diameter_m / 2), reverse=True)
        if before.run == after.run:
            for radius in np.arange(narrow, wide, STEP_M):
                for angle in np.arange(0.0, 2 * math.pi, STEP_M / radius):
                    yield np.array(after.frame.rolled(angle).point(0.0, radius))


def seen(shape: PipeShape, point: Floats) -> float:
    """The distance of the nearest wall or edge as the kernel sees it."""
    hit, least = np.zeros(7), math.inf
    x, y, z = point
    for k in range(len(shape.solids)):
        if walls.foot(x, y, z, shape.solids, k, hit) and hit[3] > -0.024:
            least = min(least, hit[3])
    for edge in shape.edges:
        at = walls._nearest_point(x, y, z, 0.0, 0.0, 0.0, edge, shape.points, 1.0)
        walls.on_edge(x, y, z, edge, shape.points, at, hit)
        away = math.sqrt(hit[3])
        beside = [
            walls.foot(x, y, z, shape.solids, int(k), hit)
            for k in edge[columns.E_ONE : columns.E_X]
            if k >= 0
        ]
        if not any(beside):
            least = min(least, away)
    return least


@pytest.fixture(scope="module")
def around() -> Callable[[str], tuple[PipeShape, list[Piece], Floats]]:
    """The shape of a network, its pieces, and places in it near its fitting."""

    def find(name: str) -> tuple[PipeShape, list[Piece], Floats]:
        route = Route(NETWORKS[name])
        pieces = [p for run in route.placement.runs.values() for p in run if p.length_m]
        middle = np.array(route.frame_at(route.joints[0].arc_m).origin)
        rng = np.random.default_rng(1)
        places = middle + rng.uniform(-0.16, 0.16, (600, 3))
        inside = [p for p in places if any(holds(pieces, n, p) for n in range(len(pieces)))]
        return shape_of(route), pieces, np.array(inside)

    return find


@pytest.mark.slow
@pytest.mark.parametrize("name", NETWORKS)
def test_the_nearest_wall_is_where_the_pipes_surface_is(
    around: Callable[[str], tuple[PipeShape, list[Piece], Floats]], name: str
) -> None:
    shape, pieces, places = around(name)
    walls = np.array(list(surface(pieces)))
    assert len(places) > 50
    for place in places:
        truly = float(np.linalg.norm(walls - place, axis=1).min())
        if truly < 0.04:
            assert seen(shape, place) == pytest.approx(truly, abs=STEP_M)


def test_a_closed_end_is_a_wall_and_an_open_one_a_rim() -> None:
    shape = shape_of(Route(tee()))
    discs = shape.solids[shape.solids[:, columns.KIND] == columns.DISC]
    assert discs[:, columns.O_X].tolist() == pytest.approx([0.6])
    assert discs[:, columns.A_X].tolist() == pytest.approx([-1.0])
    assert len(shape.edges) == 3  # entry, exit and the mouth
    assert len(shape.points) == shape.edges[:, columns.E_COUNT].sum()


def test_the_centre_line_of_a_route_goes_on_straight_behind_an_elbow() -> None:
    legs = shape_of(Route(line(Straight(0.2), Elbow(Q, 0.18)))).legs
    assert legs[:, columns.C_ARC] == pytest.approx([0.0, 0.2, 0.2 + Q * 0.18])
    assert legs[-1, columns.C_TX : columns.C_TZ + 1] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    assert legs[-1, columns.C_LENGTH] == 0.0
