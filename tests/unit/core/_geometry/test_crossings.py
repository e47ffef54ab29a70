"""Pieces that run into each other are found as all pairs would tell, though few are compared."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import pi
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pirate_sm.core._geometry import placement, route
from pirate_sm.core._geometry.network import (
    Elbow,
    Mitre,
    Network,
    NetworkRun,
    Piece,
    Reducer,
    Segment,
    Straight,
    planar,
)
from pirate_sm.core._geometry.placement import crossings, meeting, place
from pirate_sm.core._geometry.route import Route, crossing, walls

TURNS = st.sampled_from([pi / 2, -pi / 2, 0.6, -1.2, 1.9])
ROLLS = st.sampled_from([0.0, 0.0, pi / 2, -0.7, pi])
FITTINGS = st.one_of(
    st.builds(Mitre, TURNS, ROLLS),
    st.builds(Elbow, TURNS, st.sampled_from([0.08, 0.2, 1.0]), ROLLS),
    st.builds(Reducer, st.sampled_from([0.0, 0.06, 0.3]), st.sampled_from([0.1, 0.12, 0.4])),
)
STRAIGHTS = st.builds(Straight, st.sampled_from([0.05, 0.3, 0.5, 1.0, 3.0]))
RUNS = st.lists(st.tuples(STRAIGHTS, FITTINGS), max_size=7)


def network(runs: Sequence[Sequence[tuple[Segment, Segment]]]) -> Network:
    """Runs one behind the other, each ending with a straight."""
    names = [f"run_{number}" for number in range(len(runs))]
    ports = ["entry", *(f"behind_{name}" for name in names)]
    return Network(
        {
            name: NetworkRun(
                0.12,
                (*(each for pair in run for each in pair), Straight(0.5)),
                ports[number],
                ports[number + 1],
                "round",
            )
            for number, (name, run) in enumerate(zip(names, runs, strict=True))
        },
        {"through": tuple(names)},
    )


def of_all_pairs(made: Network) -> list[tuple[Piece, Piece]]:
    """The same answer, by comparing each piece with each other one."""
    placed = place(made)
    neighbours = placement._neighbours(made, placed)
    pieces = [piece for run in placed.runs.values() for piece in run]
    return [
        (one, other)
        for one, other in combinations(pieces, 2)
        if frozenset((id(one), id(other))) not in neighbours
        and placement._closer(
            placement._axis(one),
            placement._axis(other),
            (placement._widest(one) + placement._widest(other)) / 2 - placement._TOUCH_M,
        )
    ]


@given(st.lists(RUNS, min_size=1, max_size=3))
@example([[(Straight(1.0), Elbow(pi / 2, 0.2))] * 4])  # a ring
# An elbow as long as it is wide, but for rounding.
@example([[*[(Straight(1.0), Mitre(pi / 2))] * 3, (Straight(1.0), Elbow(0.6, 0.2))]])
def test_a_round_pipe_runs_into_itself_where_all_pairs_say_so(
    runs: list[list[tuple[Segment, Segment]]],
) -> None:
    made = network(runs)

    assert list(crossings(made, place(made))) == of_all_pairs(made)


@given(st.lists(st.tuples(STRAIGHTS, st.builds(Mitre, TURNS)), max_size=9))
def test_a_planar_pipe_runs_into_itself_where_all_pairs_say_so(
    parts: list[tuple[Segment, Segment]],
) -> None:
    made = Route(planar(0.12, (*(each for pair in parts for each in pair), Straight(0.5))))
    side_a, side_b = walls(made)
    shapes = [(side_a[n], side_b[n], side_b[n + 1], side_a[n + 1]) for n in range(len(made.pieces))]
    first = next(
        (
            (made.pieces[i], made.pieces[k])
            for i, k in combinations(range(len(shapes)), 2)
            if k - i > 1 and route._overlap(shapes[i], shapes[k])
        ),
        None,
    )

    assert crossing(made) == first


COORDINATES = st.integers(-5, 5).map(float)
POINTS = st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES), min_size=1, max_size=3)


@given(st.lists(st.tuples(POINTS, st.sampled_from([0.0, 0.5, 1.0])), max_size=8))
def test_boxes_meet_where_they_meet_along_all_axes(
    shapes: list[tuple[list[tuple[float, float, float]], float]],
) -> None:
    def apart(one: int, other: int) -> float:
        (points, more), (others, around) = shapes[one], shapes[other]
        return max(
            max(min(a) - max(b), min(b) - max(a)) - more - around
            for a, b in zip(zip(*points, strict=True), zip(*others, strict=True), strict=True)
        )

    found = meeting([points for points, _ in shapes], [around for _, around in shapes])

    assert found == [pair for pair in combinations(range(len(shapes)), 2) if apart(*pair) <= 0.0]


@pytest.mark.parametrize("count", [20, 40, 80])
def test_only_pieces_beside_each_other_are_compared(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared: list[object] = []
    closer = placement._closer

    def counted(*given_: Any) -> bool:
        compared.append(given_)
        return closer(*given_)

    monkeypatch.setattr(placement, "_closer", counted)
    stair = [(Straight(1.0), Elbow(pi / 2 * (-1) ** n, 0.18)) for n in range(count)]
    made = network([stair])

    assert not list(crossings(made, place(made)))
    assert len(compared) <= 2 * count
