"""A report as one HTML page that needs nothing else and asks for nothing."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from math import isfinite
from pathlib import Path
from string import Template
from typing import Any, TypeAlias

from pirate_sm import __version__
from pirate_sm.errors import UsageError
from pirate_sm.report.model import Chart, Lane, Light, Report, Scene, Sentence, Series, Wheel
from pirate_sm.report.strip import strip

Json: TypeAlias = dict[str, Any]

SIGNS = {
    "succeeded": ("✓", "Succeeded"),
    "failed": ("✗", "Failed"),
    "interrupted": ("■", "Interrupted"),
    "fault": ("!", "Ended by a fault"),
    "unfinished": ("…", "Unfinished"),
}
"""How a run ended, as a sign and in words."""

_STORY_SIGNS = {"phase": "", "trouble": "!", "person": "☺", "end": "■"}
_SPEEDS = (0.25, 0.5, 1, 2, 4, 8, 16)
_SCRIPTS = ("base.js", "scene.js", "timeline.js", "plots.js", "player.js")
_LIBRARY = "uplot"
_PLACE_PER_M = 1e4
"""Places of wheels are written in tenths of a millimetre."""


def html(report: Report) -> str:
    """The page.

    Raises:
        UsageError: The library that plots is not installed.
    """
    library = _library()
    folder = files("pirate_sm.report") / "page"
    sign, outcome = SIGNS[report.outcome]
    script = "\n".join((folder / name).read_text("utf-8") for name in _SCRIPTS)
    style = (library / "uPlot.min.css").read_text("utf-8")
    return Template((folder / "page.html").read_text("utf-8")).substitute(
        generator=f"pirate-sm {escape(__version__)}",
        recording=escape(report.recording),
        title=escape(report.title),
        outcome=outcome,
        kind=report.outcome,
        sign=sign,
        short=escape(report.summary[0] if report.summary else ""),
        style=f"{style}\n{(folder / 'page.css').read_text('utf-8')}",
        summary="\n".join(_summary(report)),
        warnings="\n".join(_warning(line) for line in report.warnings),
        story="\n".join(_told(report)),
        robot=_robot(report.scene),
        strip=strip(report),
        diagram=report.diagram,
        facts="\n".join(_facts(report)),
        duration=f"{report.duration_s:.3f}",
        step=f"{_step(report.duration_s):g}",
        speeds="".join(_speed(each) for each in _SPEEDS),
        data=_inside_script(report_json(report)),
        library=(library / "uPlot.iife.js").read_text("utf-8"),
        script=f"(() => {{\n'use strict';\n{script}\n}})();",
    )


def _library() -> Path:
    """The folder with the script and the style of the library that plots.

    Its Python part is for notebooks and is never imported.
    """
    spec = find_spec(_LIBRARY)
    places = spec.submodule_search_locations if spec else None
    folder = Path(next(iter(places))) / "static" if places else None
    if folder is None or not (folder / "uPlot.iife.js").is_file():
        raise UsageError(
            "the report needs uplot-python, which is not installed: pip install 'pirate-sm[report]'"
        )
    return folder


def _warning(line: str) -> str:
    return f'<p class="warning"><span aria-hidden="true">!</span> {escape(line)}</p>'


def _summary(report: Report) -> Iterable[str]:
    """How it ended, right behind that why, then the rest; the header has the first sentence."""
    lines = [f"<p>{escape(line)}</p>" for line in report.summary[1:]]
    return [*lines[:1], *map(_failure, report.failures), *lines[1:]]


def _failure(failure: Sentence) -> str:
    where = f"in <b>{escape(failure.topic)}</b>: " if failure.topic else ""
    return (
        f'<p class="cause"><button type="button" data-at="{failure.before_s:.3f}">'
        f'{failure.at_s:.2f} s</button> <span><span class="sign" aria-hidden="true">✗</span> '
        f"{where}{escape(failure.text)}</span></p>"
    )


def _told(report: Report) -> Iterable[str]:
    for sentence in report.story:
        sign = _STORY_SIGNS[sentence.kind]
        mark = f'<span class="sign" aria-hidden="true">{sign}</span> ' if sign else ""
        topic = f"<b>{escape(sentence.topic)}</b> " if sentence.topic else ""
        yield (
            f'<li class="{sentence.kind}"><button type="button" data-at="{sentence.at_s:.3f}">'
            f"{sentence.at_s:.2f} s</button> <span>{mark}{topic}{escape(sentence.text)}</span></li>"
        )


def _robot(scene: Scene | None) -> str:
    if scene is None:
        return '<p class="empty">Nothing is known of where the robot was.</p>'
    about = "The robot in its pipe, to scale" if scene.walls else "The robot, to scale"
    if scene.source == "reckoned":
        about += ", where its joints and its odometer take it to be"
    return (
        f'<canvas id="scene" role="img" aria-label="{about}"></canvas>'
        '<div class="below"><p id="pose"></p>'
        '<button id="follow" type="button" aria-pressed="false">Follow closely</button></div>'
        f'<p class="hint">{_robot_key(scene)}</p>'
    )


def _robot_key(scene: Scene) -> str:
    """What the signs in the picture mean."""
    signs = ["Links with a line in them are held (dashed: not yet confirmed)"]
    if scene.source == "truth" and scene.walls:
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
    """What an arrow key moves the slider by: a tenth of a second, more in a long run."""
    return 0.1 if duration_s < 120 else 0.5 if duration_s < 600 else 1.0


def _speed(factor: float) -> str:
    selected = " selected" if factor == 1 else ""
    return f'<option value="{factor:g}"{selected}>{factor:g} ×</option>'


def _inside_script(data: Json) -> str:
    """JSON that cannot end the element that it stands in."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


# --- the model as JSON ------------------------------------------------------------------------


def report_json(report: Report) -> Json:
    """The report as the page's script reads it; curves with the same times share them."""
    clocks = _Clocks()
    found = {
        "duration": _seconds(report.duration_s),
        "opens": _seconds(report.opens_at_s),
        "lanes": [_lane(each) for each in report.lanes],
        "charts": [_chart(each, clocks) for each in report.charts],
        "scene": _scene(report.scene, clocks) if report.scene else None,
    }
    return {**found, "clocks": clocks.written}


class _Clocks:
    """Times in ms, each as the step from the one before."""

    def __init__(self) -> None:
        self.written: list[list[int]] = []
        self._numbers: dict[tuple[int, ...], int] = {}

    def number(self, times_s: Sequence[float]) -> int:
        """Under which number these times are written."""
        key = tuple(_steps([round(time * 1e3) for time in times_s]))
        if key not in self._numbers:
            self._numbers[key] = len(self.written)
            self.written.append(list(key))
        return self._numbers[key]


def _steps(values: Iterable[int]) -> Iterable[int]:
    before = 0
    for value in values:
        yield value - before
        before = value


def _chart(chart: Chart, clocks: _Clocks) -> Json:
    return {
        "title": chart.title,
        "unit": chart.unit,
        "digits": chart.digits,
        "note": chart.note,
        "series": [_series(each, chart.digits, clocks) for each in chart.series],
    }


def _series(series: Series, digits: int, clocks: _Clocks) -> Json:
    values = [_number(value, digits) for value in series.values]
    return {
        "name": series.name,
        "clock": clocks.number(series.times_s),
        "values": values,
        "stepped": series.stepped,
        "main": series.main,
    }


def _number(value: float, digits: int) -> float | int | None:
    """The value without decimals that mean nothing; what is unknown is null."""
    if not isfinite(value):
        return None
    rounded = round(value, digits)
    return int(rounded) if rounded == int(rounded) else rounded


def _lane(lane: Lane) -> Json:
    return {
        "name": lane.name,
        "spans": [[_seconds(s.start_s), _seconds(s.end_s), *s[2:]] for s in lane.spans],
        "marks": [[_seconds(mark.at_s), *mark[1:]] for mark in lane.marks],
    }


def _seconds(time_s: float) -> float:
    return round(time_s, 3)


def _scene(scene: Scene, clocks: _Clocks) -> Json:
    paths = [
        list(_steps([round(pose[wheel][axis] * _PLACE_PER_M) for pose in scene.poses]))
        for wheel in range(len(scene.wheels))
        for axis in (0, 1)
    ]
    return {
        "source": scene.source,
        "clock": clocks.number(scene.times_s),
        "paths": paths,
        "perMetre": _PLACE_PER_M,
        "walls": [[[round(x, 5), round(y, 5)] for x, y in wall] for wall in scene.walls],
        "radius": scene.wheel_radius_m,
        "half": scene.half_thickness_m,
        "wheels": [_wheel(each, clocks) for each in scene.wheels],
        "parts": [_lane(each) for each in scene.parts],
        "lights": [_light(each, clocks) for each in scene.lights],
    }


def _wheel(wheel: Wheel, clocks: _Clocks) -> Json:
    return {
        "name": wheel.name,
        "part": wheel.part,
        "angle": _series(wheel.angle, 2, clocks),
        "drive": _series(wheel.drive, 3, clocks),
    }


def _light(light: Light, clocks: _Clocks) -> Json:
    return {"name": light.name, "at": light.at, "level": _series(light.level, 3, clocks)}
