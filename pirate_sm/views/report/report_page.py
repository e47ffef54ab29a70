"""A report as one HTML page that loads no other file, with JSON for its scripts."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from importlib.resources.abc import Traversable
from math import isfinite
from string import Template
from typing import Any, TypeAlias

from pirate_sm import __version__
from pirate_sm.core.palette import DAY, NIGHT, THEMES, Palette
from pirate_sm.views.report.contents import (
    Chart,
    DrawnWheel,
    Lane,
    Light,
    Outcome,
    Report,
    RobotScene,
    Sentence,
    Series,
    SpaceScene,
    Stepping,
)
from pirate_sm.views.report.film_strip import seen_words, strip

# --- JSON for its scripts -----------------------------------------------------------------------


_DIRECTION = 1e4
"""Directions are written in parts of ten thousand."""

_MM = 1e3


def steps(values: Iterable[int]) -> Iterable[int]:
    """Yield each value as the difference from the one before."""
    before = 0
    for value in values:
        yield value - before
        before = value


def paths_json(poses: Sequence[Sequence[Sequence[float]]], per_unit: float) -> list[list[int]]:
    """Return each coordinate of each point over time, in whole parts of a unit, as differences."""
    if not poses:
        return []
    return [
        list(steps([round(pose[number][axis] * per_unit) for pose in poses]))
        for number, point in enumerate(poses[0])
        for axis in range(len(point))
    ]


def rounded(point: Iterable[float]) -> list[float]:
    """Return the coordinates to a hundredth of a millimetre."""
    return [round(value, 5) for value in point]


def space_json(space: SpaceScene) -> dict[str, Any]:
    """Return the scene as JSON; the wheels' paths are next to it."""
    return {
        "normals": paths_json(space.normals, _DIRECTION),
        "perUnit": _DIRECTION,
        "rear": space.rear,
        "width": space.wheel_width_m,
        "walls": [
            {
                "around": len(rings[0]),
                "mm": [
                    round(value * _MM, 1) for ring in rings for point in ring for value in point
                ],
            }
            for rings in space.walls
        ],
        "views": [
            {
                "name": name,
                "axes": axes,
                "outlines": [[rounded(corner) for corner in outline] for outline in outlines],
            }
            for name, axes, outlines in space.sides
        ],
        "way": [[*rounded(point), diameter_m] for point, diameter_m in space.way],
        "names": [[name, *rounded(point)] for name, point in space.names],
    }


Json: TypeAlias = dict[str, Any]

_PLACE_PER_M = 1e4
"""Positions of wheels are written in tenths of a millimetre."""


def report_json(report: Report) -> Json:
    """Return the report as JSON for the page's script; curves with equal times share them."""
    clocks = _Clocks()
    found = {
        "duration": _seconds(report.duration_s),
        "opens": _seconds(report.opens_at_s),
        "lanes": [_lane(each) for each in report.lanes],
        "charts": [_chart(each, clocks) for each in report.charts],
        "scene": _scene(report.scene, clocks) if report.scene else None,
        "gaps": [[_seconds(each) for each in gap] for gap in report.gaps],
        "running": report.outcome == "running",
        "source": report.source,
        "lines": {name: [*each] for name, each in report.lines.items()},
        "stepping": _stepping(report.stepping),
    }
    return {**found, "clocks": clocks.written}


class _Clocks:
    """Lists of times in ms, each time as the difference from the one before."""

    def __init__(self) -> None:
        self.written: list[list[int]] = []
        self._numbers: dict[tuple[int, ...], int] = {}

    def number(self, times_s: Sequence[float]) -> int:
        """Return the number under which these times are written."""
        key = tuple(steps([round(time * 1e3) for time in times_s]))
        if key not in self._numbers:
            self._numbers[key] = len(self.written)
            self.written.append(list(key))
        return self._numbers[key]


def _chart(chart: Chart, clocks: _Clocks) -> Json:
    return {
        "title": chart.title,
        "unit": chart.unit,
        "digits": chart.digits,
        "note": chart.note,
        "series": [_series(each, chart.digits, clocks) for each in chart.series],
        **({"bands": chart.bands} if chart.bands else {}),
    }


def _series(series: Series, digits: int, clocks: _Clocks) -> Json:
    values = [_number(value, digits) for value in series.values]
    found: Json = {
        "name": series.name,
        "clock": clocks.number(series.times_s),
        "values": values,
        "stepped": series.stepped,
        "main": series.main,
    }
    if series.like is not None:
        found["like"] = series.like
    if series.band is not None:
        times_s, *bounds = series.band
        low, high = ([_number(value, digits) for value in each] for each in bounds)
        found["band"] = {"clock": clocks.number(times_s), "low": low, "high": high}
    return found


def _number(value: float, digits: int) -> float | int | None:
    """Return the value without insignificant decimals; unknown is null."""
    if not isfinite(value):
        return None
    rounded = round(value, digits)
    return int(rounded) if rounded == int(rounded) else rounded


def _lane(lane: Lane) -> Json:
    found: Json = {
        "name": lane.name,
        "spans": [[_seconds(s.start_s), _seconds(s.end_s), *s[2:]] for s in lane.spans],
        "marks": [[_seconds(mark.at_s), *mark[1:]] for mark in lane.marks],
    }
    expected = [[_seconds(e.from_s), _seconds(e.until_s), e.about] for e in lane.expected]
    return {**found, "expected": expected} if expected else found


def _seconds(time_s: float) -> float:
    return round(time_s, 3)


def _stepping(it: Stepping) -> Json:
    return {
        "lines": [*it.lines],
        "begun": [[_seconds(at_s), line] for at_s, line in it.begun],
        "breakpoints": [[_seconds(at_s), [*lines]] for at_s, lines in it.breakpoints],
    }


def _scene(scene: RobotScene, clocks: _Clocks) -> Json:
    space = scene.space
    poses: Sequence[Sequence[Sequence[float]]] = space.poses if space else scene.poses
    found = {
        "source": scene.source,
        "clock": clocks.number(scene.times_s),
        "paths": paths_json(poses, _PLACE_PER_M),
        "perMetre": _PLACE_PER_M,
        "walls": [[rounded(corner) for corner in wall] for wall in scene.walls],
        "radius": scene.wheel_radius_m,
        "half": scene.half_thickness_m,
        "wheels": [_wheel(each, clocks) for each in scene.wheels],
        "parts": [_lane(each) for each in scene.parts],
        "lights": [_light(each, clocks) for each in scene.lights],
    }
    return found if space is None else {**found, "space": space_json(space)}


def _wheel(wheel: DrawnWheel, clocks: _Clocks) -> Json:
    return {
        "name": wheel.name,
        "part": wheel.part,
        "angle": _series(wheel.angle, 2, clocks),
        "drive": _series(wheel.drive, 3, clocks),
    }


def _light(light: Light, clocks: _Clocks) -> Json:
    return {"name": light.name, "at": light.at, "level": _series(light.level, 3, clocks)}


# --- the style of every page --------------------------------------------------------------------


def page_style() -> str:
    """Return the stylesheet, in the light, dark or contrast that the reader's system asks for.

    Printed paper is white: the attribute ``data-printing`` is set while a page is laid out for it.
    """
    rules = (
        _root(DAY),
        _for("screen and (prefers-color-scheme: dark)", NIGHT),
        _for("(prefers-contrast: more)", THEMES["contrast_light"]),
        _for(
            "screen and (prefers-color-scheme: dark) and (prefers-contrast: more)",
            THEMES["contrast"],
        ),
        f":root[data-printing] {{ {variables(DAY)} }}",
    )
    shapes = (files("pirate_sm.views.report") / "page" / "page.css").read_text("utf-8")
    return "\n".join((*rules, shapes))


def variables(palette: Palette) -> str:
    """Return the palette as custom properties of CSS."""
    return " ".join(f"--{role.replace('_', '-')}: {colour};" for role, colour in palette.items())


def _root(palette: Palette) -> str:
    return f":root {{ {variables(palette)} }}"


def _for(medium: str, palette: Palette) -> str:
    return f"@media {medium} {{ {_root(palette)} }}"


# --- the page -----------------------------------------------------------------------------------


PAGE = files("pirate_sm.views.report") / "page"
PLOTS = PAGE / "uplot-1.6.32"
SPACE = PAGE / "three-0.170.0"
_SPACE_NAME = "THREE"


def plot_script() -> str:
    """Return the library that plots as a script that defines ``uPlot``, with its licence."""
    return _licensed(PLOTS, (PLOTS / "uPlot.iife.min.js").read_text("utf-8"))


def plot_style() -> str:
    """Return the style sheet of the library that plots."""
    return (PLOTS / "uPlot.min.css").read_text("utf-8")


def three_script() -> str:
    """Return the library that draws in space as a script that defines ``THREE``, with its licence.

    The vendored file is a module. One inside a page cannot be imported without an address, so that
    its list of exports becomes the members of an object.
    """
    module = (SPACE / "three.module.min.js").read_text("utf-8")
    body, _, exports = module.rpartition("export{")
    names = (
        each.split(" as ") for each in exports.strip().removesuffix(";").rstrip("}").split(",")
    )
    members = ",".join(f"{each[-1]}:{each[0]}" for each in names)
    return _licensed(
        SPACE, f"const {_SPACE_NAME}=(()=>{{'use strict';{body}\nreturn {{{members}}};}})();"
    )


def _licensed(folder: Traversable, script: str) -> str:
    """Return a script below the licence in its folder, without addresses to look up."""
    licence = (folder / "LICENSE").read_text("utf-8").strip()
    return f"/*\n{licence}\n*/\n{script}"


SIGNS = {
    "succeeded": ("✓", "Succeeded"),
    "failed": ("✗", "Failed"),
    "interrupted": ("■", "Interrupted"),
    "fault": ("!", "Ended by a fault"),
    "unfinished": ("…", "Unfinished"),
    "running": ("▶", "Running"),
}
"""Sign and words for each outcome."""

_STORY_SIGNS = {"phase": "", "trouble": "!", "person": "☺", "end": "■"}
_SPEEDS = (0.25, 0.5, 1, 2, 4, 8, 16)
_SCRIPTS = ("base.js", "scene.js", "timeline.js", "plots.js", "stepping.js", "player.js")


def fragments(report: Report) -> dict[str, str]:
    """Return the parts of the page that are HTML made of the report, by their names."""
    short = escape(report.summary[0] if report.summary else "")
    endings = _badge(report.outcome)
    if report.other is not None:
        endings = f"{_badge(report.outcome, 'A ')}{_badge(report.other.report.outcome, 'B ')}"
    return {
        "ending": f'{endings}\n<p class="short">{short}</p>',
        "words": "\n".join((*map(_warning, report.warnings), *_summary(report))),
        "robot": _robot(report.scene),
        "space": (PAGE / "space.html").read_text("utf-8") if _is_in_space(report) else "",
        "strip": strip(report),
        "seen": seen_words(report.photos),
        "story": "\n".join(_story(report)),
        "diagram": report.diagram,
        "facts": "\n".join(_facts(report)),
    }


def _badge(outcome: Outcome, whose: str = "") -> str:
    sign, text = SIGNS[outcome]
    return f'<p class="outcome {outcome}">{whose}<span aria-hidden="true">{sign}</span> {text}</p>'


def _is_in_space(report: Report) -> bool:
    return report.scene is not None and report.scene.space is not None


def html(report: Report, version: str | None = None, buttons: Sequence[str] = ()) -> str:
    """Return the page as HTML.

    Args:
        report: The report.
        version: Name of the report among those of a run that is under way, for a page that asks
            its server for what has changed since; None: it needs no server.
        buttons: What those who may act can press.
    """
    served, data = version is not None, report_json(report)
    in_space = _is_in_space(report)
    names = [*_SCRIPTS, *(["space.js"] if in_space else []), *(["live.js"] if served else [])]
    names += ["acting.js"] if buttons else []
    script = "\n".join((PAGE / name).read_text("utf-8") for name in names)
    libraries = [plot_script(), *([three_script()] if in_space else [])]
    return Template((PAGE / "page.html").read_text("utf-8")).substitute(
        generator=f"pirate-sm {escape(__version__)}",
        recording=escape(report.recording),
        title=escape(report.title),
        outcome=SIGNS[report.outcome][1],
        connect="; connect-src 'self'" if served else "",
        style=f"{plot_style()}\n{page_style()}",
        duration=f"{report.duration_s:.3f}",
        step=f"{_step(report.duration_s):g}",
        acting=_acting(buttons) if buttons else "",
        speeds="".join(_speed(each) for each in _SPEEDS),
        data=_inside_script({**data, "version": version} if served else data),
        library="\n".join(libraries),
        script=f"(() => {{\n'use strict';\n{script}\n}})();",
        **fragments(report),
    )


def _acting(buttons: Iterable[str]) -> str:
    """Return the buttons with which viewers act; the script shows them to who may."""
    each = "".join(
        f'<button type="button" data-press="{escape(name)}">{escape(_label(name))}</button>'
        for name in buttons
    )
    about = "The run itself"
    return (
        f'<div class="acting" id="acting" role="group" aria-label="{about}">{each}'
        '<p id="answered" role="status"></p></div>'
    )


def _label(button: str) -> str:
    run = {
        "stop": "STOP",
        "pause": "Pause the mission",
        "continue": "Continue the mission",
        "step": "One step",
    }
    return run.get(button) or f"Say: {button.removeprefix('word ')}"


def _warning(line: str) -> str:
    return f'<p class="warning"><span aria-hidden="true">!</span> {escape(line)}</p>'


def _summary(report: Report) -> Iterable[str]:
    """Return the summary with the failures, without the first sentence, which the header has."""
    lines = [f"<p>{escape(line)}</p>" for line in report.summary[1:]]
    return [*lines[:1], *map(_failure, report.failures), *map(_doubt, report.doubts), *lines[1:]]


def _failure(failure: Sentence) -> str:
    return _pointed(failure, failure.before_s, "cause", "✗")


def _doubt(doubt: Sentence) -> str:
    return _pointed(doubt, doubt.at_s, "doubt", "△")


def _pointed(it: Sentence, at_s: float, kind: str, sign: str) -> str:
    """Return a sentence that leads to its time."""
    where = f"in <b>{escape(it.topic)}</b>: " if it.topic else ""
    return (
        f'<p class="{kind}"><button type="button" data-at="{at_s:.3f}">'
        f'{it.at_s:.2f} s</button> <span><span class="sign" aria-hidden="true">{sign}</span> '
        f"{where}{escape(it.text)}</span></p>"
    )


def _story(report: Report) -> Iterable[str]:
    for sentence in report.story:
        sign = _STORY_SIGNS[sentence.kind]
        mark = f'<span class="sign" aria-hidden="true">{sign}</span> ' if sign else ""
        topic = f"<b>{escape(sentence.topic)}</b> " if sentence.topic else ""
        yield (
            f'<li class="{sentence.kind}"><button type="button" data-at="{sentence.at_s:.3f}">'
            f"{sentence.at_s:.2f} s</button> <span>{mark}{topic}{escape(sentence.text)}</span></li>"
        )


def _robot(scene: RobotScene | None) -> str:
    if scene is None:
        return '<p class="empty">Nothing is known of where the robot was.</p>'
    piped = scene.walls or scene.space
    about = "The robot in its pipe, to scale" if piped else "The robot, to scale"
    if scene.source == "reckoned":
        about += ", where its joints and its odometer take it to be"
    return (
        f"{_canvases(scene, about)}"
        '<div class="below"><p id="pose"></p>'
        '<button id="follow" type="button" aria-pressed="false">Follow closely</button></div>'
        f'<p class="hint">{_robot_key(scene)}</p>'
    )


def _canvases(scene: RobotScene, about: str) -> str:
    """Return a canvas for each view."""
    if scene.space is None:
        return f'<canvas id="scene" role="img" aria-label="{about}"></canvas>'
    return "".join(
        f'<figure><figcaption>{view.name}</figcaption><canvas id="{name}" role="img" '
        f'aria-label="{about}, {view.name[:1].lower()}{view.name[1:]}"></canvas></figure>'
        for name, view in zip(("scene", "scene-side"), scene.views, strict=False)
    )


def _robot_key(scene: RobotScene) -> str:
    """Return the explanation of the signs in the picture."""
    signs = ["Links with a line in them are held (dashed: not yet confirmed)"]
    if scene.source == "truth" and scene.walls and scene.space is None:
        signs.append("a bar marks a wheel at a wall")
    return f"{', '.join([*signs, 'an arrow a driven wheel'])}. 1 is the front."


def _facts(report: Report) -> Iterable[str]:
    yield "<dl>"
    for fact in report.facts:
        yield f"<dt>{escape(fact.name)}</dt><dd>{escape(fact.text)}</dd>"
    yield "</dl>"
    if report.files:
        yield "<details><summary>Files and their SHA-256</summary><table>"
        for name, digest in report.files.items():
            yield f"<tr><td>{escape(name)}</td><td><code>{escape(digest)}</code></td></tr>"
        yield "</table></details>"


def _step(duration_s: float) -> float:
    """Return the slider's step for an arrow key: 0.1 s, more in a long run."""
    return 0.1 if duration_s < 120 else 0.5 if duration_s < 600 else 1.0


def _speed(factor: float) -> str:
    selected = " selected" if factor == 1 else ""
    return f'<option value="{factor:g}"{selected}>{factor:g} ×</option>'


def _inside_script(data: Json) -> str:
    """Return JSON that cannot end its script element."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
