"""The order of the vertices on each rank, with few crossings."""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Sequence

SWEEPS = 24

Layers = list[list[int]]


def ordered(layers: Layers, segments: Sequence[tuple[int, int]]) -> Layers:
    """Return the layers, each in the order with the fewest crossings found.

    Args:
        layers: Vertices by rank; the given order breaks ties.
        segments: Upper and lower vertex, on consecutive ranks.
    """
    count = sum(map(len, layers))
    above: list[list[int]] = [[] for _ in range(count)]
    below: list[list[int]] = [[] for _ in range(count)]
    for upper, lower in segments:
        above[lower].append(upper)
        below[upper].append(lower)
    starts = [_walked(layers, below, above, turn) for turn in (False, True)]
    tries = [_improved(start, above, below) for start in (*starts, layers)]
    return min(tries, key=lambda found: found[0])[1]


def _walked(
    layers: Layers, below: Sequence[Sequence[int]], above: Sequence[Sequence[int]], turn: bool
) -> Layers:
    """Return the layers in the order of a depth-first walk along the segments."""
    rank = {vertex: number for number, layer in enumerate(layers) for vertex in layer}
    walked: Layers = [[] for _ in layers]
    seen: set[int] = set()
    for first in (vertex for layer in layers for vertex in layer):
        waiting = [first]
        while waiting:
            vertex = waiting.pop()
            if vertex not in seen:
                seen.add(vertex)
                walked[rank[vertex]].append(vertex)
                following = [*below[vertex], *above[vertex]]
                waiting += following if turn else reversed(following)
    return walked


def _improved(
    layers: Layers, above: Sequence[Sequence[int]], below: Sequence[Sequence[int]]
) -> tuple[int, Layers]:
    """Return the fewest crossings found by sweeping down and up, and the layers with them."""
    best = [list(layer) for layer in layers]
    fewest = _crossings(best, below)
    current = [list(layer) for layer in layers]
    for sweep in range(SWEEPS):
        if not fewest:
            break
        downwards = sweep % 2 == 0
        _sweep(current, above if downwards else below, downwards)
        _exchange(current, above, below)
        crossings = _crossings(current, below)
        if crossings < fewest:
            best, fewest = [list(layer) for layer in current], crossings
    return fewest, best


def _sweep(layers: Layers, neighbours: Sequence[Sequence[int]], downwards: bool) -> None:
    """Sort each layer by the mean position of each vertex's neighbours."""
    for layer in layers[1:] if downwards else layers[-2::-1]:
        place = _places(layers)
        middle = {
            vertex: sum(place[each] for each in neighbours[vertex]) / len(neighbours[vertex])
            for vertex in layer
            if neighbours[vertex]
        }
        free = iter(sorted(middle, key=middle.__getitem__))
        layer[:] = [next(free) if vertex in middle else vertex for vertex in layer]


def _places(layers: Layers) -> dict[int, int]:
    return {vertex: place for layer in layers for place, vertex in enumerate(layer)}


def _exchange(
    layers: Layers, above: Sequence[Sequence[int]], below: Sequence[Sequence[int]]
) -> None:
    """Swap neighbours in a layer while that reduces crossings."""
    place = _places(layers)
    improved = True
    while improved:
        improved = False
        for layer in layers:
            for left in range(len(layer) - 1):
                one, other = layer[left], layer[left + 1]
                saved = sum(
                    _pair(near[one], near[other], place) - _pair(near[other], near[one], place)
                    for near in (above, below)
                )
                if saved > 0:
                    layer[left], layer[left + 1] = other, one
                    place[one], place[other] = left + 1, left
                    improved = True


def _pair(left: Sequence[int], right: Sequence[int], place: dict[int, int]) -> int:
    """Return the crossings between the segments of two neighbouring vertices."""
    return sum(place[one] > place[other] for one in left for other in right)


def _crossings(layers: Layers, below: Sequence[Sequence[int]]) -> int:
    place = _places(layers)
    total = 0
    for layer in layers:
        ends: list[int] = []
        for vertex in layer:
            targets = sorted(place[lower] for lower in below[vertex])
            total += sum(len(ends) - bisect_right(ends, target) for target in targets)
            for target in targets:
                insort(ends, target)
    return total
