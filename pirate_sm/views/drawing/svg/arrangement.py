"""The positions of all parts of a graph in the picture, in pixels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from pirate_sm.views.drawing.graph.graph import Cluster, Edge, EdgeKind, Graph, Node, NodeKind
from pirate_sm.views.drawing.svg.layered import layered
from pirate_sm.views.drawing.svg.ranks import NOTHING, EdgeRoute, LayoutLink, Point, Size
from pirate_sm.views.drawing.wrapping import INDENT, balanced, cells, wrapped

ADVANCE = 0.61
"""Width of a character per font size of a fixed-width font; 0.602 in the widest common one."""
TITLE_FONT, TEXT_FONT, LABEL_FONT = 13.0, 12.0, 11.0
TITLE_LINE, TEXT_LINE, LABEL_LINE = 20.0, 16.0, 14.0
PADDING = 10.0
MARGIN = 16.0
FRAME = 14.0
"""Distance between a cluster's frame and its content."""
FRAME_TITLE = 22.0
BETWEEN_FRAMES = 24.0
DOT = 14.0
SIGN = 16.0
"""Width of the sign of an end's outcome."""
SHAPE = 1.6
"""Preferred ratio of width to height of all clusters together."""
NODE_COLUMNS, END_COLUMNS, LABEL_COLUMNS = 46, 30, 28
LEAST_HEADING = 60

_ONWARDS, _ASIDE = 8, 1
"""Weights of the first edge out of a node and of all others."""


@dataclass(frozen=True, slots=True)
class Box:
    """A node with its position.

    Attributes:
        corner: Upper left corner.
        lines: Its lines, wrapped.
    """

    node: Node
    corner: Point
    size: Size
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Arrow:
    """All edges of one kind from one node to another.

    Attributes:
        lines: Each line of the label, with its edge.
        room: Size of the label at ``route.label``.
    """

    edges: tuple[Edge, ...]
    route: EdgeRoute
    lines: tuple[tuple[str, Edge], ...]
    room: Size


@dataclass(frozen=True, slots=True)
class ClusterFrame:
    """A cluster's frame."""

    cluster: Cluster
    corner: Point
    size: Size


@dataclass(frozen=True, slots=True)
class Arrangement:
    """The whole picture."""

    size: Size
    heading: tuple[str, ...]
    frames: tuple[ClusterFrame, ...]
    boxes: tuple[Box, ...]
    arrows: tuple[Arrow, ...]
    notes: tuple[str, ...]
    notes_at: float


@dataclass(frozen=True, slots=True)
class _Part:
    """One cluster, positioned from (0, 0)."""

    size: Size
    frames: tuple[ClusterFrame, ...]
    boxes: tuple[Box, ...]
    arrows: tuple[Arrow, ...]


def arranged(graph: Graph) -> Arrangement:
    """Return the positions of all parts, without overlaps."""
    parts = [_part(graph, cluster) for cluster in graph.clusters]
    places, inside = _side_by_side([part.size for part in parts])
    columns = max(LEAST_HEADING, int(inside.width / (TEXT_FONT * ADVANCE)))
    heading = (graph.title, *wrapped(graph.description, columns))
    top = MARGIN + TITLE_LINE + TEXT_LINE * (len(heading) - 1) + MARGIN
    shifted = [
        _moved(part, MARGIN + x, top + y) for part, (x, y) in zip(parts, places, strict=True)
    ]
    notes = graph.note_lines(columns)
    notes_at = top + inside.height + (MARGIN if notes else 0.0)
    texts = max(cells(line) for line in (*heading, *notes)) * TITLE_FONT * ADVANCE
    width = max(inside.width, texts) + 2 * MARGIN
    return Arrangement(
        Size(width, notes_at + len(notes) * TEXT_LINE + MARGIN),
        heading,
        tuple(frame for part in shifted for frame in part.frames),
        tuple(box for part in shifted for box in part.boxes),
        tuple(arrow for part in shifted for arrow in part.arrows),
        notes,
        notes_at,
    )


def _part(graph: Graph, cluster: Cluster) -> _Part:
    nodes = [node for node in graph.nodes if node.cluster == cluster.id]
    number = {node.id: place for place, node in enumerate(nodes)}
    bundles: dict[tuple[str, str, EdgeKind], list[Edge]] = {}
    for edge in graph.edges:
        if edge.source in number:
            bundles.setdefault((edge.source, edge.target, edge.kind), []).append(edge)
    lines = [_lines(node) for node in nodes]
    sizes = [_size(node, own) for node, own in zip(nodes, lines, strict=True)]
    labels = [_label(edges) for edges in bundles.values()]
    first = {source: place for place, (source, *_) in reversed(list(enumerate(bundles)))}
    links = []
    for place, ((source, target, _), label) in enumerate(zip(bundles, labels, strict=True)):
        weight = _ONWARDS if first[source] == place else _ASIDE
        links.append(LayoutLink(number[source], number[target], _room(label), weight))
    layout = layered(sizes, links)
    boxes = tuple(map(Box, nodes, layout.corners, sizes, lines))
    arrows = tuple(
        Arrow(tuple(edges), route, label, link.label)
        for edges, route, label, link in zip(
            bundles.values(), layout.routes, labels, links, strict=True
        )
    )
    part = _Part(layout.size, (), boxes, arrows)
    return _framed(part, cluster) if cluster.title else part


def _framed(part: _Part, cluster: Cluster) -> _Part:
    title = cells(cluster.title) * TITLE_FONT * ADVANCE
    size = Size(max(part.size.width, title) + 2 * FRAME, part.size.height + FRAME_TITLE + 2 * FRAME)
    inside = _moved(part, (size.width - part.size.width) / 2, FRAME + FRAME_TITLE)
    return replace(inside, size=size, frames=(ClusterFrame(cluster, (0.0, 0.0), size),))


def _moved(part: _Part, x: float, y: float) -> _Part:
    def at(point: Point) -> Point:
        return point[0] + x, point[1] + y

    return _Part(
        part.size,
        tuple(replace(frame, corner=at(frame.corner)) for frame in part.frames),
        tuple(replace(box, corner=at(box.corner)) for box in part.boxes),
        tuple(
            replace(
                arrow,
                route=replace(
                    arrow.route,
                    points=tuple(map(at, arrow.route.points)),
                    label=at(arrow.route.label),
                ),
            )
            for arrow in part.arrows
        ),
    )


def _lines(node: Node) -> tuple[str, ...]:
    if node.kind in {NodeKind.SUCCEED, NodeKind.FAIL}:
        return tuple(line for each in node.lines for line in balanced(each, END_COLUMNS))
    return tuple(line for each in node.lines for line in wrapped(each, NODE_COLUMNS, INDENT))


def _size(node: Node, lines: Sequence[str]) -> Size:
    if node.kind is NodeKind.INITIAL:
        return Size(DOT, DOT)
    sign = SIGN if node.kind in {NodeKind.SUCCEED, NodeKind.FAIL} else 0.0
    title = cells(node.title) * TITLE_FONT * ADVANCE + sign
    text = max((cells(line) for line in lines), default=0) * TEXT_FONT * ADVANCE
    height = TITLE_LINE + PADDING + (len(lines) * TEXT_LINE + PADDING / 2 if lines else 0.0)
    return Size(max(title, text) + 2 * PADDING, height)


def _label(edges: Iterable[Edge]) -> tuple[tuple[str, Edge], ...]:
    return tuple((line, edge) for edge in edges for line in balanced(edge.label, LABEL_COLUMNS))


def _room(label: Sequence[tuple[str, Edge]]) -> Size:
    if not label:
        return NOTHING
    width = max(cells(line) for line, _ in label) * LABEL_FONT * ADVANCE
    return Size(width, len(label) * LABEL_LINE)


def _side_by_side(sizes: Sequence[Size]) -> tuple[list[Point], Size]:
    """Return a position for each, row by row, with an overall shape near the preferred one."""
    widths = {sum(size.width + BETWEEN_FRAMES for size in sizes[:n]) for n in range(len(sizes) + 1)}
    return min(
        (_rows(sizes, width) for width in sorted(widths)),
        key=lambda found: max(found[1].width / SHAPE, found[1].height),
    )


def _rows(sizes: Sequence[Size], most: float) -> tuple[list[Point], Size]:
    places: list[Point] = []
    x = y = height = width = 0.0
    for size in sizes:
        if x and x + size.width > most:
            x, y, height = 0.0, y + height + BETWEEN_FRAMES, 0.0
        places.append((x, y))
        height, width = max(height, size.height), max(width, x + size.width)
        x += size.width + BETWEEN_FRAMES
    return places, Size(width, y + height)
