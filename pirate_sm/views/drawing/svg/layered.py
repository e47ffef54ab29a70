"""A layered layout: ranks from top to bottom, few crossings, long edges straight.

The stages are those of Sugiyama, Tagawa and Toda, "Methods for visual understanding of hierarchical
system structures" (1981), with labels as vertices of their own as in Gansner, Koutsofios, North and
Vo, "A technique for drawing directed graphs" (1993).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from pirate_sm.views.drawing.svg.ranks import (
    NOTHING,
    EdgeRoute,
    GraphLayout,
    Layers,
    LayoutLink,
    Point,
    Size,
    ordered,
    ranks,
    turned,
)

# --- x coordinates ------------------------------------------------------------------------------


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
    """The vertices of each rank and their present positions."""

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
        """Return between which x the vertex can be while its neighbours stay."""
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


# --- stages -------------------------------------------------------------------------------------


GAP = 22.0
"""Distance between neighbours on a rank."""
RANK_GAP = 28.0
"""The least distance between two ranks; it grows with the width of the links between them."""
LARGEST_RANK_GAP = 80.0
SLOPE = 0.16
PORT_GAP = 64.0
"""The largest distance between two links on one side of a box."""
LABEL_GAP = 6.0
"""Distance between a link and its label."""
LOOP = 30.0
"""Width of a link to its own box."""
LEAST_STRAIGHT = 10.0
"""Length of the arrow head at the end of a link."""
INNER_WEIGHT = 4
"""Weight of a long link's middle over its ends, which keeps it straight."""


@dataclass
class _Plan:
    """The state of the layout between stages.

    Attributes:
        sizes: Size of each vertex; those after the boxes are bends and labels of links.
        chains: For each link its vertices from top to bottom.
        labels: The vertex of each link's label.
    """

    boxes: Sequence[Size]
    links: Sequence[LayoutLink]
    upwards: tuple[bool, ...]
    rank: list[int]
    sizes: list[Size] = field(default_factory=list)
    vertices: list[Vertex] = field(default_factory=list)
    chains: list[list[int]] = field(default_factory=list)
    labels: dict[int, int] = field(default_factory=dict)
    layers: Layers = field(default_factory=list)


def layered(boxes: Sequence[Size], links: Sequence[LayoutLink]) -> GraphLayout:
    """Return a layout in which no label covers a box, another label or a foreign link.

    Args:
        boxes: In reading order: a cycle is cut before its first box.
        links: Links between boxes, by their indices.
    """
    plan = _Plan(boxes, links, turned(len(boxes), links), [])
    plan.rank = _ranks(plan)
    _add_vertices(plan)
    segments = [(upper, lower) for chain in plan.chains for upper, lower in pairwise(chain)]
    plan.layers = ordered(plan.layers, segments)
    joints = _joints(plan)
    inner = [chain[1:-1] for chain in plan.chains if len(chain) > 2]
    x = abscissae(plan.layers, plan.vertices, [*joints.values()], inner, GAP)
    edge = min((x[v] - plan.vertices[v].left for v in range(len(x))), default=0.0)
    return _placed(plan, [each - edge for each in x], joints)


def _is_loop(link: LayoutLink) -> bool:
    return link.source == link.target


def _ranks(plan: _Plan) -> list[int]:
    pairs = []
    for link, upwards in zip(plan.links, plan.upwards, strict=True):
        if not _is_loop(link):
            upper, lower = (link.target, link.source) if upwards else (link.source, link.target)
            pairs.append((upper, lower, 1 if link.label == NOTHING else 2, link.weight))
    return ranks(len(plan.boxes), pairs)


def _add_vertices(plan: _Plan) -> None:
    plan.layers = [[] for _ in range(max(plan.rank, default=-1) + 1)]
    beside = [0.0] * len(plan.boxes)
    for link in plan.links:
        if _is_loop(link):
            reach = LOOP + LABEL_GAP + link.label.width
            beside[link.source] = max(beside[link.source], reach)
    for box, size in enumerate(plan.boxes):
        half = size.width / 2
        _add(plan, plan.rank[box], size, Vertex(half, half + beside[box]))
    for number, (link, upwards) in enumerate(zip(plan.links, plan.upwards, strict=True)):
        plan.chains.append([] if _is_loop(link) else _chain(plan, number, link, upwards))


def _add(plan: _Plan, rank: int, size: Size, vertex: Vertex) -> int:
    plan.sizes.append(size)
    plan.vertices.append(vertex)
    plan.layers[rank].append(len(plan.sizes) - 1)
    return len(plan.sizes) - 1


def _chain(plan: _Plan, number: int, link: LayoutLink, upwards: bool) -> list[int]:
    """Return the vertices of a link from the top; its label is on the rank next to its source."""
    upper, lower = (link.target, link.source) if upwards else (link.source, link.target)
    ways = range(plan.rank[upper] + 1, plan.rank[lower])
    chain = [upper]
    for rank in ways:
        has_label = rank == (ways[-1] if upwards else ways[0]) and link.label != NOTHING
        if has_label:
            size, right = link.label, LABEL_GAP + link.label.width
            plan.labels[number] = len(plan.sizes)
        else:
            size, right = NOTHING, 0.0
        chain.append(_add(plan, rank, size, Vertex(0.0, right)))
    return [*chain, lower]


def _joints(plan: _Plan) -> dict[tuple[int, int], Segment]:
    """Return each segment of each link, with the ports at the boxes, by link and segment."""
    place = {vertex: p for layer in plan.layers for p, vertex in enumerate(layer)}
    below: dict[int, list[tuple[int, int]]] = {}
    above: dict[int, list[tuple[int, int]]] = {}
    for number, chain in enumerate(plan.chains):
        if chain:
            below.setdefault(chain[0], []).append((place[chain[1]], number))
            above.setdefault(chain[-1], []).append((place[chain[-2]], number))
    begins = _ports(plan, below)
    ends = _ports(plan, above)
    joints: dict[tuple[int, int], Segment] = {}
    for number, chain in enumerate(plan.chains):
        last = len(chain) - 2
        for piece in range(last + 1):
            begin = begins[number] if piece == 0 else 0.0
            end = ends[number] if piece == last else 0.0
            weight = plan.links[number].weight * (INNER_WEIGHT if 0 < piece < last else 1)
            joints[number, piece] = Segment(chain[piece], chain[piece + 1], begin, end, weight)
    return joints


def _ports(plan: _Plan, sides: dict[int, list[tuple[int, int]]]) -> dict[int, float]:
    """Return where each link meets this side of its box, to the right of the box's middle."""
    ports: dict[int, float] = {}
    for box, meeting in sides.items():
        gap = min(PORT_GAP, plan.boxes[box].width / (len(meeting) + 1))
        for turn, (_, number) in enumerate(sorted(meeting)):
            ports[number] = (turn - (len(meeting) - 1) / 2) * gap
    return ports


def _placed(plan: _Plan, x: list[float], joints: dict[tuple[int, int], Segment]) -> GraphLayout:
    tops, bottoms = _bands(plan, x, joints)
    rank = {vertex: r for r, layer in enumerate(plan.layers) for vertex in layer}
    middle = [(tops[rank[v]] + bottoms[rank[v]]) / 2 for v in range(len(plan.sizes))]
    corners = tuple(
        (x[box] - size.width / 2, middle[box] - size.height / 2)
        for box, size in enumerate(plan.boxes)
    )
    routes = []
    for number, link in enumerate(plan.links):
        if _is_loop(link):
            routes.append(_loop(plan, link, x[link.source], middle[link.source]))
            continue
        spans = [(tops[rank[vertex]], bottoms[rank[vertex]]) for vertex in plan.chains[number]]
        label = plan.labels.get(number)
        at_label = (0.0, 0.0)
        if label is not None:
            at_label = (x[label] + LABEL_GAP, middle[label] - plan.sizes[label].height / 2)
        points = _way(plan, number, x, middle, joints, spans)
        routes.append(
            EdgeRoute(tuple(reversed(points) if plan.upwards[number] else points), at_label)
        )
    width = max((x[v] + plan.vertices[v].right for v in range(len(x))), default=0.0)
    return GraphLayout(Size(width, bottoms[-1] if bottoms else 0.0), corners, tuple(routes))


def _way(
    plan: _Plan,
    number: int,
    x: list[float],
    middle: list[float],
    joints: dict[tuple[int, int], Segment],
    spans: list[tuple[float, float]],
) -> list[Point]:
    """Return the link's points from top to bottom; it bends only between ranks."""
    upper, *ways, lower = plan.chains[number]
    begin = x[upper] + joints[number, 0].upper_port
    end = x[lower] + joints[number, len(ways)].lower_port
    top = middle[upper] + plan.boxes[upper].height / 2
    bottom = middle[lower] - plan.boxes[lower].height / 2
    leave, arrive = spans[0][1], spans[-1][0]
    if plan.upwards[number]:
        leave = max(leave, top + LEAST_STRAIGHT)
    else:
        arrive = min(arrive, bottom - LEAST_STRAIGHT)
    points = [(begin, top), (begin, leave)]
    for vertex, span in zip(ways, spans[1:-1], strict=True):
        points += [(x[vertex], y) for y in span]
    return [*points, (end, arrive), (end, bottom)]


def _bands(
    plan: _Plan, x: list[float], joints: dict[tuple[int, int], Segment]
) -> tuple[list[float], list[float]]:
    """Return the top and the bottom of each rank."""
    rank = {vertex: r for r, layer in enumerate(plan.layers) for vertex in layer}
    swing = [0.0] * len(plan.layers)
    for each in joints.values():
        far = abs(x[each.upper] + each.upper_port - x[each.lower] - each.lower_port)
        swing[rank[each.upper]] = max(swing[rank[each.upper]], far)
    tops: list[float] = []
    bottoms: list[float] = []
    y = 0.0
    for layer, far in zip(plan.layers, swing, strict=True):
        tops.append(y)
        bottoms.append(y + max((plan.sizes[vertex].height for vertex in layer), default=0.0))
        y = bottoms[-1] + min(LARGEST_RANK_GAP, max(RANK_GAP, far * SLOPE))
    return tops, bottoms


def _loop(plan: _Plan, link: LayoutLink, x: float, y: float) -> EdgeRoute:
    size = plan.boxes[link.source]
    side, half = x + size.width / 2, min(12.0, size.height / 4)
    label = (side + LOOP + LABEL_GAP, y - link.label.height / 2)
    return EdgeRoute(((side, y - half), (side + LOOP, y), (side, y + half)), label, loop=True)
