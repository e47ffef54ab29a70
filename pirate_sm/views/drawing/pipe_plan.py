"""Draws a pipe to scale as SVG: from above, and from the side if it does not lie in a plane."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.core.geometry import Place
from pirate_sm.core.models import Pipe
from pirate_sm.running.recording.viewers.pipe_walls import upright
from pirate_sm.views.drawing.pipe_views import (
    NamedPoint,
    SideSeen,
    WayPoint,
    centre_line,
    named_points,
    sides,
)
from pirate_sm.views.drawing.svg.arrangement import MARGIN, TEXT_LINE, TITLE_LINE
from pirate_sm.views.drawing.svg.svg_writer import paper, px, text_at

_WIDE = 900.0
"""Width of the drawing without its margins, px."""

_MOST_SCALE = 1_000.0
"""Size of a metre, px: a short pipe does not fill the width."""

_RULERS_M = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_RULER = 60.0
"""The ruler is at least so long, px."""

_STYLE = """
.drawing .wall { stroke-width: 3; stroke-linejoin: round }
.drawing .axis { fill: none; stroke-width: 1; stroke-dasharray: 8 6 }
.drawing .ruler { fill: none; stroke-width: 1.5 }
"""
_COLOURS = """
.drawing .wall {{ fill: none; stroke: {wall} }}
.drawing .bore {{ fill: {bore} }}
.drawing .axis {{ stroke: {faint} }}
.drawing .ruler {{ stroke: {soft} }}
"""


def plan_svg(pipe: Pipe, title: str) -> str:
    """Return the drawing of a pipe without faults as one self-contained SVG element."""
    route = pipe.route()
    frame = upright(route.up)
    seen, way = sides(route, frame), [*centre_line(route, frame)]
    names, y = [*named_points(route, frame)], MARGIN + TITLE_LINE
    scale = min(_MOST_SCALE, *(_WIDE / _size(side)[0] for side in seen))
    lines: list[str] = []
    for side in seen:
        lines += _view(side, way, names, scale, y)
        y += TEXT_LINE + _size(side)[1] * scale + MARGIN
    lines += _ruler(scale, y)
    about = f"{title}: {pipe.description}" if pipe.description else title
    wide = max(_size(side)[0] for side in seen) * scale
    head = paper(wide + 2 * MARGIN, y + 2 * MARGIN, f"{about}, to scale", _STYLE, _COLOURS)
    return "\n".join(
        [*head, text_at("title", MARGIN, MARGIN, TITLE_LINE, about), *lines, "</svg>", ""]
    )


def _corners(side: SideSeen) -> tuple[float, float, float, float]:
    xs, ys = zip(*(corner for outline in side.outlines for corner in outline), strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def _size(side: SideSeen) -> Place:
    x0, y0, x1, y1 = _corners(side)
    return x1 - x0, y1 - y0


def _view(
    side: SideSeen, way: list[WayPoint], names: list[NamedPoint], scale: float, top: float
) -> Iterator[str]:
    """Yield the pipes as they are seen from one side, with the centre line and the names."""
    x0, _, _, y1 = _corners(side)
    right, up = side.axes

    def to(x: float, y: float) -> Place:
        return MARGIN + (x - x0) * scale, top + TEXT_LINE + (y1 - y) * scale

    areas = "".join(f"{_path([to(*corner) for corner in outline])}Z" for outline in side.outlines)
    yield text_at("text soft", MARGIN, top, TEXT_LINE, side.name)
    yield f'<path class="wall" d="{areas}"/><path class="bore" d="{areas}"/>'
    line = [to(each.point[right], each.point[up]) for each in way]
    yield f'<path class="axis" d="{_path(line)}"/>'
    for name, point in names:
        x, y = to(point[right], point[up])
        yield text_at("text", x + 4, y - TEXT_LINE, TEXT_LINE, name)


def _ruler(scale: float, y: float) -> Iterator[str]:
    """Yield a line of a round length, with the length."""
    long_m = next((each for each in _RULERS_M if each * scale >= _RULER), _RULERS_M[-1])
    ends = [(MARGIN, y - 4), (MARGIN, y), (MARGIN + long_m * scale, y)]
    yield f'<path class="ruler" d="{_path([*ends, (ends[-1][0], y - 4)])}"/>'
    text = f"{long_m:g} m" if long_m >= 1 else f"{long_m * 100:g} cm"
    yield text_at("text soft", ends[-1][0] + 6, y - TEXT_LINE / 2, TEXT_LINE, text)


def _path(points: list[Place]) -> str:
    return "M" + "L".join(f"{px(x)} {px(y)}" for x, y in points)
