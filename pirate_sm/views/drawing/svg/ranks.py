"""The ranks of a layered layout: what is laid out, the rank of each box, the order on each rank.

Lengths are in pixels, y grows downwards.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Sequence
from dataclasses import dataclass

# --- input and result ---------------------------------------------------------------------------


Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Size:
    """The size of a box or label."""

    width: float
    height: float


NOTHING = Size(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class LayoutLink:
    """A link from one box to another.

    Attributes:
        label: The size of its label.
        weight: How much its shortness and straightness count.
    """

    source: int
    target: int
    label: Size = NOTHING
    weight: int = 1


@dataclass(frozen=True, slots=True)
class EdgeRoute:
    """The route of a link.

    Attributes:
        points: From border to border. If two consecutive points have different x, the link curves
            from one vertical to the next; other pieces are straight.
        loop: Whether it leads back to its own box and is drawn next to it.
        label: Upper left corner of the label.
    """

    points: tuple[Point, ...]
    label: Point
    loop: bool = False


@dataclass(frozen=True, slots=True)
class GraphLayout:
    """The positions of all boxes and links; nothing is left of or above (0, 0).

    Attributes:
        corners: Upper left corner of each box.
        routes: One for each link.
    """

    size: Size
    corners: tuple[Point, ...]
    routes: tuple[EdgeRoute, ...]


# --- ranks --------------------------------------------------------------------------------------


def turned(count: int, links: Sequence[LayoutLink]) -> tuple[bool, ...]:
    """Return for each link whether it leads upwards.

    A link does if it leads to an earlier box from which its source is reachable. Without these
    links there is no cycle.
    """
    reached = _reached(count, links)
    return tuple(
        link.target < link.source and link.source in reached[link.target] for link in links
    )


def _reached(count: int, links: Sequence[LayoutLink]) -> list[set[int]]:
    following: list[list[int]] = [[] for _ in range(count)]
    for link in links:
        following[link.source].append(link.target)
    reached: list[set[int]] = []
    for box in range(count):
        found: set[int] = set()
        waiting = [box]
        while waiting:
            for target in following[waiting.pop()]:
                if target not in found:
                    found.add(target)
                    waiting.append(target)
        reached.append(found)
    return reached


def ranks(count: int, pairs: Sequence[tuple[int, int, int, int]]) -> list[int]:
    """Return the rank of each box; the first is 0.

    Args:
        count: How many boxes there are.
        pairs: Upper box, lower box, least difference of their ranks, weight. No cycle.
    """
    order = _sorted(count, pairs)
    above: list[list[tuple[int, int, int]]] = [[] for _ in range(count)]
    below: list[list[tuple[int, int, int]]] = [[] for _ in range(count)]
    for upper, lower, length, weight in pairs:
        above[lower].append((upper, length, weight))
        below[upper].append((lower, length, weight))
    rank = [0] * count
    for _ in range(2):
        for box in order:
            lowest = (rank[upper] + length for upper, length, _ in above[box])
            rank[box] = max(lowest, default=rank[box])
        for box in order:
            # No link leads here: it may be just above the first box that others reach too.
            shared = [rank[low] - length for low, length, _ in below[box] if len(above[low]) > 1]
            if not above[box] and shared:
                rank[box] = min(shared)
    for box in reversed(order):
        # As low as possible, if more links lead down than up.
        if sum(w for *_, w in below[box]) > sum(w for *_, w in above[box]):
            rank[box] = min(rank[lower] - length for lower, length, _ in below[box])
    first = min(rank, default=0)
    return [each - first for each in rank]


def _sorted(count: int, pairs: Sequence[tuple[int, int, int, int]]) -> list[int]:
    """Return the boxes in topological order, otherwise in their own order."""
    missing = [0] * count
    below: list[list[int]] = [[] for _ in range(count)]
    for upper, lower, *_ in pairs:
        missing[lower] += 1
        below[upper].append(lower)
    order = [box for box in range(count) if not missing[box]]
    for box in order:
        for lower in below[box]:
            missing[lower] -= 1
            if not missing[lower]:
                order.append(lower)
    return order


# --- the order on each rank ---------------------------------------------------------------------


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
