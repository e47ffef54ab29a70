"""Draws a robot from the side as SVG: with joints at 0, clamped, and what each state does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, pairwise
from math import atan2, cos, degrees, hypot, radians, sin

from pirate_sm.core.geometry import Place
from pirate_sm.core.units import in_degrees
from pirate_sm.views.drawing.side_view import LEGEND, SCALE, WRONG, SideView
from pirate_sm.views.drawing.svg.arrangement import MARGIN, TEXT_LINE, TITLE_LINE
from pirate_sm.views.drawing.svg.svg_writer import at, circle, paper, px, rectangle, text_at
from pirate_sm.views.drawing.wrapping import cells, wrapped

_LETTER = 7.3
"""Width of a character of 12 px, px [measured in the fonts of drawings]."""

_LABEL = 250.0
"""Width of the column with the names of states, px [decided]."""

_LEAST_SCALE = 1500.0
"""Size of a metre in the drawing, px, of a robot whose names are short [decided]."""

_HEAD = 7.0
_STYLE = """
.drawing .link { stroke-width: 1.2 }
.drawing .wheel, .drawing .wall, .drawing .turn { stroke-width: 2 }
.drawing .zero { stroke-dasharray: 3 3 }
.drawing .press { stroke-width: 4 }
.drawing .at { text-anchor: middle; font-size: 12px }
.drawing .big { font-size: 17px; font-weight: bold }
"""
_COLOURS = """
.drawing .bore {{ fill: {bore} }}
.drawing .wall, .drawing .zero {{ stroke: {wall} }}
.drawing .link {{ fill: {body}; stroke: {line} }}
.drawing .wheel {{ fill: {paper}; stroke: {ink} }}
.drawing .turn, .drawing .press {{ stroke: {path} }}
.drawing .tip {{ fill: {path} }}
.drawing text.ahead {{ fill: {path} }}
.drawing text.back {{ fill: {late} }}
.drawing text.bad {{ fill: {bad} }}
.drawing .bad.wheel {{ fill: {bad_box}; stroke: {bad}; stroke-width: 4 }}
.drawing .bad.press {{ stroke: {bad} }}
.drawing .bad.tip {{ fill: {bad} }}
.drawing .band {{ fill: {box} }}
"""


def side_svg(view: SideView) -> str:
    """Return the drawing as one self-contained SVG element."""
    sheet = _Sheet(view)
    lines = [*sheet.at_zero(), *sheet.clamped(), *sheet.states(), *sheet.notes()]
    width, profile = sheet.width, view.profile
    about = f"{profile.robot} from the side: {profile.description}"
    head = paper(width, sheet.y + MARGIN, about, _STYLE, _COLOURS)
    title = text_at("title", MARGIN, MARGIN, TITLE_LINE, f"{profile.robot}: {profile.description}")
    return "\n".join([*head, title, *lines, "</svg>", ""])


@dataclass
class _Sheet:
    """What is drawn from the top to the bottom; ``y`` is where the next thing begins, px."""

    view: SideView
    y: float = MARGIN + TITLE_LINE

    def __post_init__(self) -> None:
        body = self.view.profile.body
        names = [self._labels(node) for node in range(len(body.wheels))]
        widest = max(cells(line) for above, below in names for line in (*above, *below))
        self.scale = max(_LEAST_SCALE, *((widest + 1) * _LETTER / x.length for x in body.links))
        self.radius = body.wheel_radius * self.scale
        self.straight = [0.0]
        for link in body.links:
            self.straight.append(self.straight[-1] - link.length * self.scale)
        half = max(self.radius, widest * _LETTER / 2)
        self.front = _LABEL + half - self.straight[-1]
        self.width = self.front + half + 3 * MARGIN

    def _labels(self, node: int) -> tuple[list[str], list[str]]:
        """Return the lines above a node, of its joint, and below it, of its wheel."""
        body = self.view.profile.body
        wheel, slots = body.wheels[node], [s for s in self.view.slots if s.column == node]
        above = [
            line
            for joint in body.joints
            if joint.wheel == wheel.name
            for line in (joint.name, f"±{in_degrees(joint.end_stop)}")
        ]
        side = "A" if wheel.direction > 0 else "B"
        below = [wheel.name, f"{wheel.part}, side {side}"]
        for each in slots:
            (below if each.slot.wheel else above).extend(each.lines)
        return above, below

    # --- its geometry --------------------------------------------------------------------------

    def at_zero(self) -> Iterator[str]:
        """Draw it with all joints at 0: names, lengths, and which way a positive angle turns."""
        body = self.view.profile.body
        labels = [self._labels(node) for node in range(len(body.wheels))]
        yield from self._written(
            f"To scale, every joint at 0: wheels of {body.wheel_radius * 1e3:g} mm radius, links "
            f"{body.body_half_thickness * 2e3:g} mm thick, {body.mass_kg:.2f} kg in all. The arc "
            "at a joint is its positive angle: the body ahead turns from the dashed line to side B."
        )
        self.y += TEXT_LINE / 2
        top = self.y + max(len(above) for above, _ in labels) * TEXT_LINE
        middle = top + 1.5 * self.radius + MARGIN
        spots = [(self.front + x, middle) for x in self.straight]
        yield from self._links(spots)
        for node, ((x, y), (above, below)) in enumerate(zip(spots, labels, strict=True)):
            yield from self._wheel(node, x, y)
            if above:
                yield from self._angle(x, y)
            for row, line in enumerate(above):
                yield _centred(x, self.y + row * TEXT_LINE, line)
            for row, line in enumerate(below):
                yield _centred(x, y + self.radius + MARGIN / 2 + row * TEXT_LINE, line)
        self.y = middle + self.radius + MARGIN + max(len(low) for _, low in labels) * TEXT_LINE
        yield from self._lengths(spots)

    def _lengths(self, spots: list[Place]) -> Iterator[str]:
        """Draw the lengths of the links, with their modules and roll joints."""
        rows = 0
        links = zip(self.view.profile.body.links, pairwise(spots), strict=True)
        for link, ((x, y), (behind, _)) in links:
            ends = f"M{px(behind)} {px(self.y - 4)}v8m0 -4H{px(x)}m0 -4v8"
            yield f'<path class="line" d="{ends}"/>'
            lines, middle = [link.module, f"{link.length * 1e3:g} mm"], (x + behind) / 2
            if link.roll:
                yield from self._roll(middle, y)
                slots = (each.lines for each in self.view.slots if each.slot.roll == link.roll)
                lines += [link.roll, *chain.from_iterable(slots)]
            for row, line in enumerate(lines):
                yield _centred(middle, self.y + 4 + row * TEXT_LINE, line)
            rows = max(rows, len(lines))
        self.y += (rows + 1) * TEXT_LINE

    def _angle(self, x: float, y: float) -> Iterator[str]:
        """Draw the zero of a joint, and the arc of a positive angle."""
        far = 1.5 * self.radius
        yield f'<path class="zero" d="M{px(x)} {px(y)}h{px(far)}"/>'
        yield from _arc(x, y, far * 0.9, 0, -50)

    def _roll(self, x: float, y: float) -> Iterator[str]:
        """Draw which way the body ahead of a roll joint turns by a positive angle."""
        high = self.view.profile.body.body_half_thickness * self.scale + 6
        path = f"M{at((x, y + high))}a{at((high / 2, high))} 0 0 0 0 {px(-2 * high + _HEAD)}"
        yield f'<path class="turn" d="{path}"/>'
        yield _tip((x, y - high), 60)

    def _links(self, spots: list[Place]) -> Iterator[str]:
        half = self.view.profile.body.body_half_thickness * self.scale
        for (x, y), (to_x, to_y) in pairwise(spots):
            long, turn = hypot(to_x - x, to_y - y), degrees(atan2(to_y - y, to_x - x))
            yield (
                f'<rect class="link" y="{px(-half)}" width="{px(long)}" '
                f'height="{px(2 * half)}" rx="4" '
                f'transform="translate({at((x, y))}) rotate({px(turn)})"/>'
            )

    def _wheel(self, node: int, x: float, y: float) -> Iterator[str]:
        bad = node in self.view.bad_wheels
        yield circle(f"{'bad ' * bad}wheel", x, y, self.radius)
        yield _centred(x, y - TEXT_LINE / 2, f"{node + 1}{WRONG * bad}", "at bad" if bad else "at")

    # --- clamped, and its states ---------------------------------------------------------------

    def clamped(self) -> Iterator[str]:
        """Draw it between two walls, with rim motion at positive duty, and what presses."""
        view = self.view
        yield from self._written(
            f"{SCALE.format(view.diameter_m * 1e3)} The arrow in a wheel is how a positive duty "
            "turns it. A thick arrow is the wall to which the state that holds most parts presses "
            "the wheel of a joint."
        )
        high, half = self.y + 2 * MARGIN, view.diameter_m / 2 * self.scale
        middle = high + half
        left, right = _LABEL - MARGIN, self.width - 2 * MARGIN
        yield rectangle("bore", left, high, right - left, 2 * half)
        for name, y in (("A", high), ("B", high + 2 * half)):
            yield f'<path class="wall" d="M{px(left)} {px(y)}H{px(right)}"/>'
            yield text_at("title", right + 6, y - TITLE_LINE / 2, TITLE_LINE, name)
        spots = [(self.front + x * self.scale, middle - y * self.scale) for x, y in view.places]
        yield from self._links(spots)
        for node, (x, y) in enumerate(spots):
            yield from self._wheel(node, x, y)
            if any(each.slot.wheel and each.column == node for each in view.slots):
                yield from _arc(x, y, self.radius * 0.7, -40, 220)
            if node in view.pressed:
                yield from self._press(x, y, view.pressed[node])
        self.y = high + 2 * half + 2 * MARGIN

    def _press(self, x: float, y: float, arrow: str) -> Iterator[str]:
        """Draw the arrow with which a joint presses its wheel, from the rim outwards."""
        up, bad = -1 if arrow[0] == "↑" else 1, "bad " * (WRONG in arrow)
        begin, end = y + up * self.radius, y + up * (self.radius + 2 * MARGIN)
        yield (f'<path class="{bad}press" d="M{px(x)} {px(begin)}V{px(end - up * _HEAD)}"/>')
        yield _tip((x, end), 90 * -up, bad, 2)
        if bad:
            yield _centred(x + 14, (begin + end) / 2 - TEXT_LINE / 2, WRONG, "at big bad")

    def states(self) -> Iterator[str]:
        """Write a line for each state, with what it does under each wheel, joint and roll joint."""
        for number, row in enumerate(self.view.rows):
            if number % 2:
                yield rectangle("band", MARGIN, self.y, self.width - 2 * MARGIN, TITLE_LINE)
            kind = "text" if row.cells else "title soft"
            indent = MARGIN + (len(row.name) - len(row.name.lstrip())) * _LETTER
            yield text_at(kind, indent, self.y, TITLE_LINE, row.name.lstrip())
            for column, text in row.cells.items():
                way = "bad" if WRONG in text else "back" if "←" in text else "ahead"
                size = "big " * (not text[-1:].isalnum() and "°" not in text)
                x = self.front + self.view.at(column) * self.scale
                yield _centred(x, self.y, text, f"at {size}{way}", TITLE_LINE)
            self.y += TITLE_LINE

    def notes(self) -> Iterator[str]:
        """Write what the signs mean, and what is wrong."""
        self.y += MARGIN
        yield from self._written(LEGEND)
        for note in self.view.notes:
            yield from self._written(note, "title bad")

    def _written(self, text: str, kind: str = "text soft") -> Iterator[str]:
        for line in wrapped(text, int((self.width - 2 * MARGIN) / _LETTER)):
            yield text_at(kind, MARGIN, self.y, TEXT_LINE, line)
            self.y += TEXT_LINE


def _centred(x: float, top: float, text: str, kind: str = "at", height: float = TEXT_LINE) -> str:
    return text_at(kind, x, top, height, text)


def _arc(x: float, y: float, radius: float, begin: float, end: float) -> Iterator[str]:
    """Draw an arrow along a circle, by angles in degrees, 0 ahead and 90 up."""
    first, last = (
        (x + radius * cos(radians(each)), y - radius * sin(radians(each))) for each in (begin, end)
    )
    large, back = int(abs(end - begin) > 180), int(end < begin)
    path = f"M{at(first)}A{at((radius, radius))} 0 {large} {back} {at(last)}"
    yield f'<path class="turn" d="{path}"/>'
    yield _tip(last, end + (-90 if back else 90))


def _tip(point: Place, towards: float, kind: str = "", size: float = 1) -> str:
    """Return the head of an arrow whose tip is at a point, by its direction in degrees."""
    long, half = _HEAD * size, _HEAD * size / 2
    return (
        f'<polygon class="{kind}tip" points="0 0 {at((-long, half))} {at((-long, -half))}" '
        f'transform="translate({at(point)}) rotate({px(-towards)})"/>'
    )
