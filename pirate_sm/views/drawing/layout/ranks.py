"""The rank of each box: links lead downwards, except those that close a cycle."""

from __future__ import annotations

from collections.abc import Sequence

from pirate_sm.views.drawing.layout.plan import LayoutLink


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
