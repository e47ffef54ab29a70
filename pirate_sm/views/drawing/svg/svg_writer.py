"""Writes a graph as SVG, in light and dark mode."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from xml.sax.saxutils import escape, quoteattr

from pirate_sm.core.palette import DAY, NIGHT, Palette
from pirate_sm.views.drawing.graph.graph import Graph, NodeKind
from pirate_sm.views.drawing.svg.arrangement import (
    ADVANCE,
    LABEL_FONT,
    LABEL_LINE,
    MARGIN,
    PADDING,
    SIGN,
    TEXT_FONT,
    TEXT_LINE,
    TITLE_LINE,
    Arrangement,
    Arrow,
    Box,
    ClusterFrame,
    arranged,
)
from pirate_sm.views.drawing.svg.ranks import EdgeRoute, Point
from pirate_sm.views.drawing.wrapping import cells, printable

FONT = 'ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, "Liberation Mono", monospace'


_SHAPES = f"""
.drawing text {{ font-family: {FONT} }}
.drawing .title {{ font-size: 13px; font-weight: bold }}
.drawing .text {{ font-size: 12px }}
.drawing .label {{ font-size: 11px }}
.drawing path {{ fill: none; stroke-linecap: round; stroke-linejoin: round }}
.drawing .line {{ stroke-width: 1.3 }}
.drawing .within .line {{ stroke-dasharray: 7 4 }}
.drawing .failure .line {{ stroke-dasharray: 1 4; stroke-width: 1.8 }}
.drawing .fault .line {{ stroke-dasharray: 9 4 1 4 }}
.drawing .taken .line {{ stroke-width: 3.2 }}
.drawing .taken .chosen {{ font-weight: bold }}
.drawing .box {{ stroke-width: 1.2 }}
.drawing .sign {{ stroke-width: 2 }}
.drawing .anywhere .box, .drawing .frame {{ stroke-dasharray: 4 3 }}
.drawing .visited .box {{ stroke-width: 2.8 }}
.drawing .ring {{ stroke-width: 1.6; fill: none }}
.drawing .number {{ font-size: 11px; font-weight: bold }}
"""

_COLOURS = """
.drawing .paper {{ fill: {paper} }}
.drawing text {{ fill: {ink} }}
.drawing .soft {{ fill: {soft} }}
.drawing .frame {{ fill: none; stroke: {line} }}
.drawing .box {{ fill: {box}; stroke: {line} }}
.drawing .initial .box {{ fill: {ink}; stroke: {ink} }}
.drawing .anywhere .box {{ fill: {paper} }}
.drawing .succeed .box {{ fill: {good_box}; stroke: {good} }}
.drawing .succeed .sign {{ stroke: {good} }}
.drawing .fail .box {{ fill: {bad_box}; stroke: {bad} }}
.drawing .fail .sign {{ stroke: {bad} }}
.drawing .visited .box {{ stroke: {path} }}
.drawing .phase.visited .box, .drawing .state.visited .box {{ fill: {path_box} }}
.drawing .ring {{ stroke: {path} }}
.drawing .badge {{ fill: {path} }}
.drawing .number {{ fill: {paper} }}
.drawing .line {{ stroke: {line} }}
.drawing .head {{ fill: {line} }}
.drawing .within .line {{ stroke: {late} }}
.drawing .within .head {{ fill: {late} }}
.drawing .failure .line {{ stroke: {bad} }}
.drawing .failure .head {{ fill: {bad} }}
.drawing .fault .line {{ stroke: {fault} }}
.drawing .fault .head {{ fill: {fault} }}
.drawing .taken .line {{ stroke: {path} }}
.drawing .taken .head {{ fill: {path} }}
"""


def stylesheet(style: str = "", more: str = "") -> str:
    """Return the style of every drawing, in the light or dark mode of the reader's system.

    Every rule is limited to ``.drawing``, so that it can be part of a larger page.

    Args:
        style: Rules of one kind of drawing.
        more: Its rules for colours, with names of the palette in braces.
    """
    day, night = (colours(palette) + more.format(**palette) for palette in (DAY, NIGHT))
    return f"{_SHAPES}{style}{day}@media screen and (prefers-color-scheme: dark) {{{night}}}\n"


def colours(palette: Palette) -> str:
    """Return the rules for the colours of the palette."""
    return _COLOURS.format(**palette)


HEAD = 8.0
BASELINE = 0.75
"""Position of the baseline in a line of text, as a share of the line's height."""
RING = 4.0
BADGE = 16.0
MOST_VISITS = 4


def svg(graph: Graph, links: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return the graph as one self-contained SVG element, for a file or a page.

    Nodes have ``data-node``, edges ``data-from`` and ``data-to``, for scripts of a page.

    Args:
        graph: The graph.
        links: The addresses to which nodes lead, by their ids.
    """
    whole = arranged(graph)
    about = f"{graph.title}: {graph.description}" if graph.description else graph.title
    lines = [*paper(whole.size.width, whole.size.height, about), *_heading(whole)]
    for frame in whole.frames:
        lines += _frame(frame)
    for arrow in sorted(whole.arrows, key=lambda each: any(edge.taken for edge in each.edges)):
        lines += _arrow(arrow)
    for box in whole.boxes:
        link = links.get(box.node.id)
        lines += _box(box) if link is None else [f"<a href={_quoted(link)}>", *_box(box), "</a>"]
    lines += _notes(whole)
    return "\n".join([*lines, "</svg>", ""])


def paper(wide: float, high: float, about: str, style: str = "", colours: str = "") -> list[str]:
    """Return the first lines of a drawing, up to its background.

    Args:
        wide: Width of the drawing, px.
        high: Height of the drawing, px.
        about: What it shows, for people who do not see it.
        style: Rules of CSS in addition to those of every drawing.
        colours: Likewise, with names of the palette in braces.
    """
    width, height = px(wide), px(high)
    return [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="drawing" role="img" width="{width}" '
        f'height="{height}" viewBox="0 0 {width} {height}" aria-label={_quoted(about)}>',
        f"<style>{escape(stylesheet(style, colours))}</style>",
        f'<rect class="paper" width="{width}" height="{height}"/>',
    ]


def visits_text(visits: Sequence[int]) -> str:
    """Return the numbers of the visits; of many only the first ones and the last."""
    if len(visits) > MOST_VISITS:
        return f"{', '.join(map(str, visits[: MOST_VISITS - 1]))} … {visits[-1]}"
    return ", ".join(map(str, visits))


def _heading(whole: Arrangement) -> Iterator[str]:
    y = MARGIN
    yield text_at("title", MARGIN, y, TITLE_LINE, whole.heading[0])
    for number, line in enumerate(whole.heading[1:]):
        yield text_at("text soft", MARGIN, y + TITLE_LINE + number * TEXT_LINE, TEXT_LINE, line)


def _notes(whole: Arrangement) -> Iterator[str]:
    for number, line in enumerate(whole.notes):
        yield text_at("text soft", MARGIN, whole.notes_at + number * TEXT_LINE, TEXT_LINE, line)


def _frame(frame: ClusterFrame) -> Iterator[str]:
    (x, y), size = frame.corner, frame.size
    yield "<g>"
    yield from _tooltip(frame.cluster.tooltip)
    yield rectangle("frame", x, y, size.width, size.height, 8)
    yield text_at("title soft", x + PADDING, y + PADDING / 2, TITLE_LINE, frame.cluster.title)
    yield "</g>"


def _box(box: Box) -> Iterator[str]:
    node, (x, y), size = box.node, box.corner, box.size
    names = [node.kind.value, *(["visited"] if node.visits else [])]
    yield f'<g class="{" ".join(names)}" data-node={_quoted(node.id)}>'
    yield from _tooltip(node.tooltip)
    if node.kind is NodeKind.INITIAL:
        radius = size.width / 2
        yield circle("box", x + radius, y + radius, radius)
    else:
        yield from _described(box)
    yield "</g>"


def _described(box: Box) -> Iterator[str]:
    node, (x, y), size = box.node, box.corner, box.size
    ends = node.kind in {NodeKind.SUCCEED, NodeKind.FAIL}
    radius = 15 if ends or node.kind is NodeKind.STATE else 5
    if node.current:
        wide, high = size.width + 2 * RING, size.height + 2 * RING
        yield rectangle("ring", x - RING, y - RING, wide, high, radius + RING)
    yield rectangle("box", x, y, size.width, size.height, radius)
    left, top = x + PADDING, y + PADDING / 2
    if ends:
        yield _sign(node.kind is NodeKind.SUCCEED, left, top + TITLE_LINE / 2)
    yield text_at("title", left + (SIGN if ends else 0.0), top, TITLE_LINE, node.title)
    for number, line in enumerate(box.lines):
        line_top = top + TITLE_LINE + PADDING / 4 + number * TEXT_LINE
        indent = (len(line) - len(line.lstrip())) * TEXT_FONT * ADVANCE
        yield text_at("text", left + indent, line_top, TEXT_LINE, line.lstrip())
    if node.visits:
        text = visits_text(node.visits)
        width = cells(text) * LABEL_FONT * ADVANCE + PADDING
        badge_x, badge_y = x - BADGE / 2, y - BADGE / 2
        yield rectangle("badge", badge_x, badge_y, max(width, BADGE), BADGE, BADGE / 2)
        middle = badge_x + max(width, BADGE) / 2
        yield (
            f'<text class="number" text-anchor="middle" x="{px(middle)}" '
            f'y="{px(badge_y + BADGE * BASELINE)}">{escaped(text)}</text>'
        )


def circle(name: str, x: float, y: float, radius: float) -> str:
    """Return a circle of a class."""
    return f'<circle class="{name}" cx="{px(x)}" cy="{px(y)}" r="{px(radius)}"/>'


def rectangle(
    name: str, x: float, y: float, width: float, height: float, radius: float = 0.0
) -> str:
    """Return a rectangle of a class, whose corners have a radius."""
    return (
        f'<rect class="{name}" x="{px(x)}" y="{px(y)}" width="{px(width)}" '
        f'height="{px(height)}" rx="{px(radius)}"/>'
    )


def _sign(good: bool, x: float, y: float) -> str:
    left, top, low = px(x), px(y - 4), px(y + 4)
    if good:
        middle, right = px(x + 3), px(x + 9)
        return f'<path class="sign" d="M{left} {px(y)}L{middle} {low}L{right} {top}"/>'
    right = px(x + 8)
    return f'<path class="sign" d="M{left} {top}L{right} {low}M{left} {low}L{right} {top}"/>'


def _arrow(arrow: Arrow) -> Iterator[str]:
    first = arrow.edges[0]
    taken = any(edge.taken for edge in arrow.edges)
    names = f"edge {first.kind.value}{' taken' if taken else ''}"
    yield (f'<g class="{names}" data-from={_quoted(first.source)} data-to={_quoted(first.target)}>')
    yield from _tooltip("\n".join(edge.tooltip or edge.label for edge in arrow.edges))
    path, head = _loop(arrow.route) if arrow.route.loop else _way(arrow.route)
    yield f'<path class="line" d="{path}"/>'
    yield f'<polygon class="head" points="{head}"/>'
    x, y = arrow.route.label
    for number, (line, edge) in enumerate(arrow.lines):
        chosen = "label chosen" if edge.taken else "label"
        yield text_at(chosen, x, y + number * LABEL_LINE, LABEL_LINE, line)
    yield "</g>"


def _way(route: EdgeRoute) -> tuple[str, str]:
    """Return the path of the line, and the points of its head."""
    points = list(route.points)
    (tip_x, tip_y), (_, before) = points[-1], points[-2]
    down = 1.0 if tip_y > before else -1.0
    points[-1] = (tip_x, tip_y - down * HEAD)
    path = [f"M{at(points[0])}"]
    for (x, y), (to_x, to_y) in pairwise(points):
        if abs(x - to_x) < 0.05:
            path.append(f"L{at((to_x, to_y))}")
            continue
        half = (y + to_y) / 2
        path.append(f"C{at((x, half))} {at((to_x, half))} {at((to_x, to_y))}")
    base = tip_y - down * HEAD
    corners = [(tip_x, tip_y), (tip_x - HEAD / 2, base), (tip_x + HEAD / 2, base)]
    return "".join(path), " ".join(map(at, corners))


def _loop(route: EdgeRoute) -> tuple[str, str]:
    begin, apex, end = route.points
    base = (end[0] + HEAD, end[1])
    reach = begin[0] + (apex[0] - begin[0]) * 4 / 3  # a cubic reaches three quarters of the way
    path = f"M{at(begin)}C{at((reach, begin[1]))} {at((reach, end[1]))} {at(base)}"
    corners = [end, (base[0], end[1] - HEAD / 2), (base[0], end[1] + HEAD / 2)]
    return path, " ".join(map(at, corners))


def text_at(name: str, x: float, top: float, height: float, text: str) -> str:
    """Return a line of text of a class, whose line begins at ``top`` and has this height."""
    y = top + height * BASELINE
    return f'<text class="{name}" x="{px(x)}" y="{px(y)}">{escaped(text)}</text>'


def _tooltip(text: str) -> Iterator[str]:
    if text.strip():
        yield f"<title>{escaped(text)}</title>"


def escaped(text: str) -> str:
    """Return the text without markup and characters that cannot be shown."""
    return escape(printable(text))


def _quoted(text: str) -> str:
    return quoteattr(printable(text))


def px(value: float) -> str:
    """Return a number of pixels as it is written."""
    return f"{value:.1f}".removesuffix(".0")


def at(point: Point) -> str:
    """Return a point as paths and lists of points have it."""
    return f"{px(point[0])} {px(point[1])}"
