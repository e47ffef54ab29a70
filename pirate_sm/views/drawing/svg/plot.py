"""A plot of curves and points as one SVG, in the colours of its page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from math import ceil, floor, isfinite, log10
from typing import Literal
from zlib import crc32

from pirate_sm.core.palette import CURVES

_WIDTH, _HEIGHT = 640.0, 300.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 62.0, 12.0, 26.0, 44.0
_LETTER = 6.0
"""Width of a letter, at most, in the mean of a name."""
_TICKS = 6
_COLOURS = len(CURVES)
_DASHES = ("", "7 3", "2 2", "9 3 2 3")
"""Curves differ in their dashes too; those of the first one are none."""

_MARKS = ("h0", "m-3 0h6m-3 -3v6", "m-2.5 -2.5l5 5m-5 0l5 -5", "m-3 0h6")
"""Points differ in their shape too: a dot, a plus, a cross, a bar."""

_SAMPLE = 24.0
"""Length of the piece of a curve in the key."""

_MOST_POINTS = 1500
"""More points of a series cannot be distinguished in a picture of this width."""


@dataclass(frozen=True)
class PlotSeries:
    """A series of points.

    Attributes:
        name: For the key; empty for none of its own.
        x: Their positions.
        y: Their values; NaN where there is none.
        look: A line, dots, or a band from ``y`` to ``upper``.
        upper: The other edge of a band.
        colour: Number of the colour; series of one colour belong together.
    """

    name: str
    x: Sequence[float]
    y: Sequence[float]
    look: Literal["line", "dots", "band"] = "line"
    upper: Sequence[float] = ()
    colour: int = 0


@dataclass(frozen=True)
class Plot:
    """A plot.

    Attributes:
        title: Above it.
        x_label: Under the horizontal axis, with its unit.
        y_label: Next to the vertical axis, with its unit.
        series: What is drawn, the last one on top.
        log_x: Whether the horizontal axis is logarithmic; then what is not positive is left out.
        most_y: What is higher is cut off; None: nothing.
        y_names: Labels at 0, 1, … of the vertical axis, from below, instead of numbers.
    """

    title: str
    x_label: str
    y_label: str
    series: tuple[PlotSeries, ...]
    log_x: bool = False
    most_y: float | None = None
    y_names: tuple[str, ...] = ()

    @property
    def left(self) -> float:
        """Where the vertical axis is."""
        return max([_LEFT, *(_LETTER * len(each) + 24.0 for each in self.y_names)])


@dataclass(frozen=True)
class _Axis:
    """Where values of an axis are in the picture."""

    low: float
    high: float
    begin: float
    end: float

    def at(self, value: float) -> float:
        share = (value - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)


def plot_svg(plot: Plot) -> str:
    """Return the plot as an SVG element."""
    shown = [(each, list(_points(each, plot))) for each in plot.series]
    x = _axis((p[0] for _, points in shown for p in points), plot.left, _WIDTH - _RIGHT)
    values = [v for _, points in shown for p in points for v in p[1:]]
    if plot.most_y is not None:
        values = [min(value, plot.most_y) for value in values]
    y = _axis(values, _HEIGHT - _BOTTOM, _TOP)
    room = f'width="{_WIDTH - plot.left - _RIGHT:g}" height="{_HEIGHT - _TOP - _BOTTOM:g}"'
    clip = f"inside-{crc32(repr(plot).encode()):x}"
    return "\n".join(
        [
            f'<svg class="plot" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img" '
            f'aria-label="{escape(plot.title)}">',
            f'<clipPath id="{clip}"><rect x="{plot.left:g}" y="{_TOP:g}" {room}/></clipPath>',
            *_frame(plot, x, y),
            f'<g clip-path="url(#{clip})">',
            *(_drawn(each, points, x, y) for each, points in shown if points),
            "</g>",
            *_key(plot.series),
            "</svg>",
        ]
    )


def _points(series: PlotSeries, plot: Plot) -> Iterator[tuple[float, ...]]:
    """Yield the points to draw: thinned, without what is unknown or not on the axis."""
    columns = (series.x, series.y, series.upper) if series.look == "band" else (series.x, series.y)
    step = max(ceil(len(series.x) / _MOST_POINTS), 1)
    for row in zip(*(column[::step] for column in columns), strict=True):
        x, *values = map(float, row)
        if all(map(isfinite, (x, *values))) and (x > 0 or not plot.log_x):
            yield (log10(x) if plot.log_x else x, *values)


def _axis(values: Iterable[float], begin: float, end: float) -> _Axis:
    found = list(values) or [0.0, 1.0]
    low, high = min(found), max(found)
    room = (high - low or abs(high) or 1.0) * 0.04
    return _Axis(low - room, high + room, begin, end)


def _ticks(axis: _Axis) -> Iterator[float]:
    """Yield round values along the axis."""
    rough = (axis.high - axis.low) / _TICKS
    power = 10.0 ** floor(log10(rough))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough)
    for number in range(ceil(axis.low / step), floor(axis.high / step) + 1):
        yield number * step


def _frame(plot: Plot, x: _Axis, y: _Axis) -> Iterator[str]:
    left, bottom, right = plot.left, _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    for value in _x_ticks(plot, x):
        at = x.at(value)
        label = f"{10**value:g}" if plot.log_x else f"{value:g}"
        yield f'<path class="grid" d="M{at:.1f} {_TOP:g}V{bottom:g}"/>'
        yield f'<text x="{at:.1f}" y="{bottom + 15:g}" text-anchor="middle">{label}</text>'
    places = list(map(float, range(len(plot.y_names)))) or list(_ticks(y))
    names = plot.y_names or [f"{value:g}" for value in places]
    for value, name in zip(places, names, strict=True):
        at = y.at(value)
        yield f'<path class="grid" d="M{left:g} {at:.1f}H{right:g}"/>'
        yield f'<text x="{left - 6:g}" y="{at + 4:.1f}" text-anchor="end">{escape(name)}</text>'
    middle = (left + right) / 2
    yield f'<text class="title" x="{left:g}" y="15">{escape(plot.title)}</text>'
    yield (
        f'<text x="{middle:g}" y="{_HEIGHT - 8:g}" text-anchor="middle">'
        f"{escape(plot.x_label)}</text>"
    )
    yield (
        f'<text transform="translate(13 {(_TOP + bottom) / 2:g}) rotate(-90)" '
        f'text-anchor="middle">{escape(plot.y_label)}</text>'
    )


def _x_ticks(plot: Plot, axis: _Axis) -> Iterator[float]:
    if not plot.log_x:
        return _ticks(axis)
    whole = range(ceil(axis.low), floor(axis.high) + 1)
    return iter([float(power) for power in whole]) if len(whole) > 1 else _ticks(axis)


def _drawn(series: PlotSeries, points: list[tuple[float, ...]], x: _Axis, y: _Axis) -> str:
    places = [f"{x.at(p[0]):.1f} {y.at(p[1]):.1f}" for p in points]
    if series.look == "dots":
        path = "".join(f"M{place}{_mark(series)}" for place in places)
        return f'<path class="dots" style="{_stroke(series)}" d="{path}"/>'
    if series.look == "band":
        back = [f"{x.at(p[0]):.1f} {y.at(p[2]):.1f}" for p in reversed(points)]
        fill = f"fill:var(--curve{series.colour % _COLOURS})"
        return f'<path class="band" style="{fill}" d="M{"L".join(places + back)}Z"/>'
    return f'<path class="curve" style="{_stroke(series)}" d="M{"L".join(places)}"/>'


def _stroke(series: PlotSeries) -> str:
    """Return the style of the series' line or points: its colour, its dashes, how thick."""
    more, number = "", series.colour % len(_DASHES)
    if series.look == "line" and _DASHES[number]:
        more = f";stroke-dasharray:{_DASHES[number]}"
    elif series.look == "dots" and number:
        more = ";stroke-width:1.2"
    return f"stroke:var(--curve{series.colour % _COLOURS}){more}"


def _mark(series: PlotSeries) -> str:
    """Return the path of one of the series' points, from its place."""
    return _MARKS[series.colour % len(_MARKS)]


def _key(series: Iterable[PlotSeries]) -> Iterator[str]:
    """Yield the names of the series at the right, each with a piece of its line."""
    named = [each for each in series if each.name]
    right = _WIDTH - _RIGHT - 6
    for number, each in enumerate(named):
        y = _TOP + 14 + 14 * number
        dots = each.look == "dots"
        sample = f"m{_SAMPLE / 2:g} 0{_mark(each)}" if dots else f"h{_SAMPLE:g}"
        at = f'x="{right - _SAMPLE - 6:g}" y="{y:g}"'
        yield (
            f'<path class="{"dots" if dots else "sample"}" style="{_stroke(each)}" '
            f'd="M{right - _SAMPLE:g} {y - 4:g}{sample}"/>'
        )
        yield f'<text {at} text-anchor="end">{escape(each.name)}</text>'
