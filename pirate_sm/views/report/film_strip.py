"""Strips of pictures: the robot in its pipe, and what the camera saw when words began.

The robot is drawn at the end of phases and of long commands. All these pictures have the same size
and scale, with the robot in the middle, as in thesis fig. 6-9.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from difflib import SequenceMatcher
from html import escape
from itertools import pairwise, zip_longest
from typing import TYPE_CHECKING, Literal, NamedTuple

from pirate_sm.core.geometry import Place
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.viewers.viewer_messages import PICTURES
from pirate_sm.views.report.contents import FlatView, Lane, Photo, Report, RobotScene
from pirate_sm.views.report.timeline import COMMANDS, DETECTOR, PHASE

if TYPE_CHECKING:
    from pirate_sm.views.report.compared_report import SecondRun

# --- the robot in its pipe ----------------------------------------------------------------------


MOST_PICTURES = 60
"""The most pictures; beyond them commands are left out first, then the shortest phases."""

_LONG_S = 0.5
"""Shorter commands have hardly moved anything."""

_APART_S = 0.3
"""Two pictures closer in time than this look the same."""

_JUST_BEFORE_S = 0.001
"""At the very end of a phase the next one has already begun."""

_MARGIN = 2.0
"""Margin around the robot, in wheel radii."""

_GRIP = 0.35
"""Width of the line in a link that is held, in thicknesses of the link."""

_MM = 1e3


class StripPicture(NamedTuple):
    """A picture of the film strip.

    Attributes:
        title: The phase or command that has just ended.
        about: The phase of a command; empty if the title names it.
        weight: Pictures with more weight are kept when there is no room for all.
    """

    at_s: float
    title: str
    kind: Literal["start", "phase", "command", "failed"]
    about: str = ""
    weight: float = 0.0


def pictures(report: Report) -> tuple[StripPicture, ...]:
    """Return the pictures of a run, in order."""
    found = [StripPicture(0.0, "start", "start", weight=float("inf"))]
    for failure in report.failures:
        phase = failure.topic
        short = failure.text.partition(":")[0].partition(" (")[0] if phase else "failed"
        found.append(StripPicture(failure.before_s, short, "failed", phase, float("inf")))
    phases, commands = (_lane(report, name) for name in (PHASE, COMMANDS))
    for start_s, end_s, name, *_ in phases.spans:
        at_s = max(start_s, end_s - _JUST_BEFORE_S) if end_s < report.duration_s else end_s
        _add(found, StripPicture(at_s, name, "phase", weight=1e6 + end_s - start_s))
    for start_s, end_s, name, kind, _ in commands.spans:
        if kind in ("done", "failed") and end_s - start_s >= _LONG_S:
            within = next((each for each in phases.spans if each[0] <= start_s < each[1]), None)
            where = within.text if within else ""
            _add(found, StripPicture(end_s, f"{name} {kind}", "command", where, end_s - start_s))
    kept = sorted(found, key=lambda each: each.weight, reverse=True)[:MOST_PICTURES]
    return tuple(sorted(kept))


def _lane(report: Report, name: str) -> Lane:
    return next((lane for lane in report.lanes if lane.name == name), Lane(name))


def _add(found: list[StripPicture], picture: StripPicture) -> None:
    """Add the picture, unless there is one at nearly the same time."""
    if all(abs(each.at_s - picture.at_s) >= _APART_S for each in found):
        found.append(picture)


def strip(report: Report) -> str:
    """Return the strip as a section of a page; empty if the robot's position is unknown."""
    if report.scene is None:
        return ""
    pipes, shown = _drawn(report, report.scene, "pipes")
    title, items = "From phase to phase", [f"<li{kind}>{text}</li>" for _, kind, text in shown]
    if report.other is not None:
        title = "From phase to phase, A above B"
        more, items = _pairs(report.other, shown)
        pipes += more
    return (
        '<section class="wide" aria-labelledby="strip-title">\n'
        f'<h2 id="strip-title">{title}</h2>\n'
        '<p class="hint">The robot as each phase, and each command that took long, was done. '
        f"{_seen(report.scene)}"
        "Filled: the front wheel; a line in a link: held. "
        '<span class="how">Choose a picture to go to its time.</span></p>\n'
        f"{pipes}"
        '<ol class="strip">\n' + "\n".join(items) + "\n</ol>\n</section>"
    )


class _Item(NamedTuple):
    """A picture with its title, as HTML."""

    title: str
    kind: str
    text: str


def _drawn(
    report: Report, scene: RobotScene, name: str, clock: Callable[[float], float] = float
) -> tuple[str, list[_Item]]:
    """Return what all pictures use, and the pictures.

    Args:
        report: The report.
        scene: Its scene.
        name: What its pipes are called in the page.
        clock: Returns the time to which a picture leads.
    """
    shown = pictures(report)
    times_s = [each.at_s for each in shown]
    drawings = [
        _Drawing(scene, view, f"{name}-{number}", times_s)
        for number, view in enumerate(scene.views)
    ]
    items = [
        _item(each, "".join(drawing.at(each.at_s) for drawing in drawings), clock(each.at_s))
        for each in shown
    ]
    return "".join(drawing.pipes for drawing in drawings), items


def _pairs(second: SecondRun, ours: Sequence[_Item]) -> tuple[str, list[str]]:
    """Return what the pictures of the second run use, and those of both in pairs by title."""
    pipes, theirs = "", list[_Item]()
    if second.report.scene is not None:
        pipes, theirs = _drawn(second.report, second.report.scene, "pipes-b", second.clock.at)
    found = []
    titles = [each.title for each in ours], [each.title for each in theirs]
    for _, a0, a1, b0, b1 in SequenceMatcher(None, *titles, autojunk=False).get_opcodes():
        for a, b in zip_longest(ours[a0:a1], theirs[b0:b1]):
            texts = (f"{a.text if a else '<span></span>'}{b.text if b else '<span></span>'}",)
            found.append(f'<li class="pair">{"".join(texts)}</li>')
    return pipes, found


def _seen(scene: RobotScene) -> str:
    """Return from where the robot is seen, as a sentence; empty in the plane of a planar pipe."""
    names = [view.name for view in scene.views if view.name]
    if len(names) > 1:
        return "Above it is seen from above, below from the side. "
    return f"It is seen {names[0][:1].lower()}{names[0][1:]}. " if names else ""


def _item(it: StripPicture, drawing: str, leads_to_s: float) -> _Item:
    sign = "✗ " if it.kind == "failed" or it.title.endswith(" failed") else ""
    about = f"<small>{_breaking(it.about)}</small>" if it.about else ""
    kind = f' class="{"failed" if sign else it.kind}"'
    text = (
        f'<button type="button" data-at="{leads_to_s:.3f}">{drawing}'
        f"<b>{sign}{_breaking(it.title)}</b>{about}<time>{it.at_s:.2f} s</time></button>"
    )
    return _Item(it.title, kind, text)


def _breaking(name: str) -> str:
    """Return the name as HTML that may be wrapped between its parts."""
    return escape(name).replace("/", "/<wbr>").replace(".", ".<wbr>").replace("_", "_<wbr>")


class _Drawing:
    """Draws a view of a scene at several times, around the robot, all to one scale.

    Args:
        scene: The scene.
        view: The view.
        name: What its pipes are called in the page.
        times_s: The times.
    """

    def __init__(
        self, scene: RobotScene, view: FlatView, name: str, times_s: Iterable[float]
    ) -> None:
        self._scene, self._view, self._name = scene, view, name
        margin = 2 * (1 + _MARGIN) * scene.wheel_radius_m
        boxes = [_box(self._pose(at_s)) for at_s in times_s]
        self._wide = max(x1 - x0 for x0, _, x1, _ in boxes) + margin
        self._high = max(y1 - y0 for _, y0, _, y1 in boxes) + margin

    def _pose(self, at_s: float) -> Sequence[Place]:
        return self._view.poses[max(0, bisect_right(self._scene.times_s, at_s) - 1)]

    @property
    def pipes(self) -> str:
        """Return what all pictures of a network use: its pipes, drawn once."""
        if not self._view.outlines:
            return ""
        areas = "".join(f"{_path(outline)}Z" for outline in self._view.outlines)
        return (
            f'<svg class="stock" aria-hidden="true"><defs><g class="pipes" id="{self._name}">'
            f'<path class="wall" stroke-width="10" d="{areas}"/><path class="bore" d="{areas}"/>'
            "</g></defs></svg>"
        )

    def at(self, at_s: float) -> str:
        """Return the picture at this time as an SVG element with the page's colours."""
        points = self._pose(at_s)
        x0, y0, x1, y1 = _box(points)
        left, top = (x0 + x1 - self._wide) / 2, -(y0 + y1 + self._high) / 2
        view = " ".join(f"{value * _MM:.0f}" for value in (left, top, self._wide, self._high))
        parts = [*self._pipe(), *self._links(points, at_s), *self._wheels(points)]
        return f'<svg viewBox="{view}" aria-hidden="true">{"".join(parts)}</svg>'

    def _pipe(self) -> Iterable[str]:
        if self._view.outlines:
            yield f'<use href="#{self._name}"/>'
        if len(self._view.walls) == 2:
            one, other = self._view.walls
            yield f'<path class="bore" d="{_path((*one, *reversed(other)))}Z"/>'
        for wall in self._view.walls:
            yield f'<path class="wall" stroke-width="5" d="{_path(wall)}"/>'

    def _links(self, points: Sequence[Place], at_s: float) -> Iterable[str]:
        scene = self._scene
        thick = 2 * scene.half_thickness_m * _MM
        for number, pair in enumerate(pairwise(points)):
            part, other = (scene.wheels[number + beside].part for beside in (0, 1))
            held = part == other and self._holds(part, at_s)
            way = f'd="{_path(pair)}"'
            yield f'<path class="link{" held" if held else ""}" stroke-width="{thick:.0f}" {way}/>'
            if held:
                yield f'<path class="grip" stroke-width="{thick * _GRIP:.0f}" {way}/>'

    def _holds(self, part: str, at_s: float) -> bool:
        spans = next((lane.spans for lane in self._scene.parts if lane.name == part), ())
        return any(span.start_s <= at_s <= span.end_s for span in spans)

    def _wheels(self, points: Sequence[Place]) -> Iterable[str]:
        radius = self._scene.wheel_radius_m * _MM
        for number, (x, y) in enumerate(points):
            yield (
                f'<circle class="wheel{"" if number else " front"}" stroke-width="5" '
                f'cx="{x * _MM:.0f}" cy="{-y * _MM:.0f}" r="{radius - 2.5:.1f}"/>'
            )


def _box(points: Sequence[Place]) -> tuple[float, float, float, float]:
    xs, ys = zip(*points, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def _path(points: Sequence[Place]) -> str:
    return "M" + "L".join(f"{x * _MM:.0f} {-y * _MM:.0f}" for x, y in points)


# --- what the camera saw ------------------------------------------------------------------------


_NEAR_S = 0.6
"""Pictures are recorded twice a second, and with each word."""

_MOST = 24


def photos_of(recording: Recording, lanes: Iterable[Lane]) -> tuple[Photo, ...]:
    """Return the picture nearest to the beginning of each word; none without a camera."""
    words = [span for lane in lanes if lane.name == DETECTOR for span in lane.spans][:_MOST]
    nearest: dict[int, tuple[float, Photo]] = {}
    if not words:
        return ()
    for shown in recording.shown(PICTURES):
        for number, word in enumerate(words):
            off_s = abs(shown.at_s - word.start_s)
            if off_s <= min(_NEAR_S, nearest.get(number, (_NEAR_S, None))[0]):
                photo = Photo(word.start_s, word.text, str(shown.content.get("data", "")))
                nearest[number] = off_s, photo
    return tuple(nearest[number][1] for number in sorted(nearest))


def seen_words(photos: Sequence[Photo]) -> str:
    """Return the section of the page with these pictures; empty without any."""
    if not photos:
        return ""
    figures = "\n".join(
        f'<li><button type="button" data-at="{photo.at_s:.3f}">'
        f'<img alt="What the camera saw" src="data:image/jpeg;base64,{escape(photo.jpeg)}">'
        f"<b>{escape(photo.word)}</b><time>{photo.at_s:.2f} s</time></button></li>"
        for photo in photos
    )
    return (
        '<section class="wide" aria-labelledby="seen-title">\n'
        '<h2 id="seen-title">What the camera saw at each word</h2>\n'
        f'<ol class="strip seen">\n{figures}\n</ol>\n</section>'
    )
