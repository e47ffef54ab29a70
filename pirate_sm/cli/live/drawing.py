"""The robot in its pipe, drawn from what the simulator knows."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from math import hypot

from rich.text import Text

from pirate_sm.model.truth import Truth
from pirate_sm.showing.canvas import ACROSS, DOWN, Canvas

WALL, LINK, WHEEL, HEAD = "bright_black", "cyan", "green", "bright_magenta"

_ROOM = 1.4
"""How many lengths of the robot are visible, at least."""

_WHEEL_DOTS = 2.0
"""The whole pipe is shown as long as the radius of a wheel is no smaller than this."""

Place = tuple[float, float]


def draw(truth: Truth, columns: int, rows: int) -> list[Text]:
    """The whole pipe where there is room for it, else what surrounds the robot.

    The first wheel, where forward is, has a colour of its own.
    """
    canvas = Canvas(columns, rows)
    scale, left, top = _frame(truth, columns * ACROSS, rows * DOWN)

    def at(place: Place) -> Place:
        return (place[0] - left) * scale, (top - place[1]) * scale

    for wall in truth.walls:
        for one, other in pairwise(wall):
            canvas.line(*at(one), *at(other), WALL)
    for one, other in pairwise(truth.wheels):
        canvas.line(*at(one), *at(other), LINK)
    for number, wheel in reversed(list(enumerate(truth.wheels))):
        canvas.disc(*at(wheel), truth.wheel_radius_m * scale, WHEEL if number else HEAD)
    return canvas.rows()


def _frame(truth: Truth, width: int, height: int) -> tuple[float, float, float]:
    """Dots per metre, and the place of the upper left corner."""
    low, high = _bounds([place for wall in truth.walls for place in wall] or truth.wheels)
    margin = truth.wheel_radius_m
    whole = min(width / (high[0] - low[0] + 2 * margin), height / (high[1] - low[1] + 2 * margin))
    length = sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(truth.wheels))
    near = min(width, height) / (_ROOM * length + 4 * margin)
    scale = whole if whole >= near or truth.wheel_radius_m * whole >= _WHEEL_DOTS else near
    seen, far = _bounds(truth.wheels)
    left = _placed((seen[0] + far[0]) / 2, width / scale, low[0] - margin, high[0] + margin)
    bottom = _placed((seen[1] + far[1]) / 2, height / scale, low[1] - margin, high[1] + margin)
    return scale, left, bottom + height / scale


def _placed(middle: float, extent: float, low: float, high: float) -> float:
    """Where a window begins: around the middle, yet not showing more beyond an edge than it must.

    A window larger than everything has everything in its middle.
    """
    if extent >= high - low:
        return (low + high - extent) / 2
    return min(max(middle - extent / 2, low), high - extent)


def _bounds(places: Iterable[Place]) -> tuple[Place, Place]:
    xs, ys = zip(*places, strict=True)
    return (min(xs), min(ys)), (max(xs), max(ys))
