"""The x coordinate of each vertex: near its neighbours, with long links straight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

ROUNDS = 40
STRAIGHTENINGS = 12
SNAP = 14.0
"""Deviations up to this many pixels are straightened."""
NO_PULL = 1e-3


@dataclass(frozen=True, slots=True)
class Vertex:
    """A vertex on a rank; its x is that of its anchor, which may be off its middle."""

    left: float
    right: float


@dataclass(frozen=True, slots=True)
class Segment:
    """A connection between two vertices on consecutive ranks.

    Attributes:
        upper_port: Distance of its upper end to the right of the upper anchor.
        lower_port: Distance of its lower end to the right of the lower anchor.
    """

    upper: int
    lower: int
    upper_port: float
    lower_port: float
    weight: float


def abscissae(
    layers: Sequence[Sequence[int]],
    vertices: Sequence[Vertex],
    segments: Sequence[Segment],
    chains: Sequence[Sequence[int]],
    gap: float,
) -> list[float]:
    """Return the x of each vertex's anchor; neighbours on a rank are at least ``gap`` apart.

    Args:
        layers: The vertices of each rank from left to right.
        vertices: The width of each vertex.
        segments: The connections.
        chains: Vertices, one below the other, that should be on one vertical.
        gap: In pixels.
    """
    pulls: list[list[tuple[int, float, float]]] = [[] for _ in vertices]
    for each in segments:
        shift = each.upper_port - each.lower_port
        pulls[each.lower].append((each.upper, shift, each.weight))
        pulls[each.upper].append((each.lower, -shift, each.weight))
    rows = _Rows(layers, vertices, gap, [0.0] * len(vertices))
    for layer in layers:
        rows.settle(layer, [(0.0, 1.0)] * len(layer))
    for number in range(ROUNDS):
        for layer in layers if number % 2 == 0 else reversed(layers):
            rows.settle(layer, [_wish(vertex, pulls[vertex], rows.x) for vertex in layer])
    rows.straighten(chains)
    rows.snap(pulls)
    return rows.x


def _wish(
    vertex: int, pulls: Sequence[tuple[int, float, float]], x: Sequence[float]
) -> tuple[float, float]:
    """Return the preferred x of the vertex alone, and its weight."""
    weight = sum(pull for _, _, pull in pulls)
    if not weight:
        return x[vertex], NO_PULL
    return sum((x[other] + shift) * pull for other, shift, pull in pulls) / weight, weight


@dataclass(frozen=True, slots=True)
class _Rows:
    """The vertices of each rank and where they stand at present."""

    layers: Sequence[Sequence[int]]
    vertices: Sequence[Vertex]
    gap: float
    x: list[float]

    def settle(self, layer: Sequence[int], wishes: Sequence[tuple[float, float]]) -> None:
        """Move a layer as near to its wishes as its order and the gaps allow (least squares).

        Taking from each wish the room that is needed left of it makes this the isotonic regression,
        which pooling adjacent violators solves.
        """
        if not layer:  # between parts of a graph that nothing joins
            return
        room = [0.0]
        for one, other in pairwise(layer):
            room.append(room[-1] + self.vertices[one].right + self.vertices[other].left + self.gap)
        blocks: list[tuple[float, float, int]] = []
        for (wish, weight), needed in zip(wishes, room, strict=True):
            value, heavy, size = wish - needed, weight, 1
            while blocks and blocks[-1][0] > value:
                before, more, members = blocks.pop()
                value = (before * more + value * heavy) / (more + heavy)
                heavy, size = heavy + more, size + members
            blocks.append((value, heavy, size))
        values = [value for value, _, size in blocks for _ in range(size)]
        for vertex, value, needed in zip(layer, values, room, strict=True):
            self.x[vertex] = value + needed

    def straighten(self, chains: Sequence[Sequence[int]]) -> None:
        """Move each chain to one vertical, or as near to one as its neighbours allow."""
        place = {vertex: (layer, p) for layer in self.layers for p, vertex in enumerate(layer)}
        for _ in range(STRAIGHTENINGS):
            for chain in sorted(chains, key=len, reverse=True):
                free = [self._free(*place[vertex]) for vertex in chain]
                least, most = max(low for low, _ in free), min(high for _, high in free)
                wanted = sum(self.x[vertex] for vertex in chain) / len(chain)
                if least <= most:
                    wanted = min(max(wanted, least), most)
                for vertex, (low, high) in zip(chain, free, strict=True):
                    self.x[vertex] = min(max(wanted, low), high)

    def snap(self, pulls: Sequence[Sequence[tuple[int, float, float]]]) -> None:
        """Move each vertex straight below what it hangs on most, where little is missing for it."""
        seen: set[int] = set()
        for layer in self.layers:
            for place, vertex in enumerate(layer):
                hung = [pull for pull in pulls[vertex] if pull[0] in seen]
                if hung:
                    other, shift, _ = max(hung, key=lambda pull: pull[2])
                    wanted = self.x[other] + shift
                    low, high = self._free(layer, place)
                    if abs(wanted - self.x[vertex]) <= SNAP and low <= wanted <= high:
                        self.x[vertex] = wanted
            seen.update(layer)

    def _free(self, layer: Sequence[int], place: int) -> tuple[float, float]:
        """Return between which x the vertex can stand while its neighbours stay."""
        vertex = layer[place]
        low, high = float("-inf"), float("inf")
        if place:
            left = layer[place - 1]
            low = self.x[left] + self.vertices[left].right + self.gap + self.vertices[vertex].left
        if place + 1 < len(layer):
            right = layer[place + 1]
            high = (
                self.x[right] - self.vertices[right].left - self.gap - self.vertices[vertex].right
            )
        return low, max(low, high)
