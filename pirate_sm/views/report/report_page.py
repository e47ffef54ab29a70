"""A report as one HTML page that loads no other file."""

from __future__ import annotations

import json
from collections.abc import Iterable
from html import escape
from importlib.resources import files
from importlib.resources.abc import Traversable
from string import Template

from pirate_sm import __version__
from pirate_sm.views.report.contents import Report, RobotScene, Sentence
from pirate_sm.views.report.film_strip import strip
from pirate_sm.views.report.page_style import page_style
from pirate_sm.views.report.report_json import Json, report_json
from pirate_sm.views.report.seen_words import seen_words

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
}
"""Sign and words for each outcome."""

_STORY_SIGNS = {"phase": "", "trouble": "!", "person": "☺", "end": "■"}
_SPEEDS = (0.25, 0.5, 1, 2, 4, 8, 16)
_SCRIPTS = ("base.js", "scene.js", "timeline.js", "plots.js", "player.js")


def html(report: Report) -> str:
    """Return the page as HTML."""
    sign, outcome = SIGNS[report.outcome]
    in_space = report.scene is not None and report.scene.space is not None
    names = (*_SCRIPTS, "space.js") if in_space else _SCRIPTS
    script = "\n".join((PAGE / name).read_text("utf-8") for name in names)
    libraries = [plot_script(), *([three_script()] if in_space else [])]
    return Template((PAGE / "page.html").read_text("utf-8")).substitute(
        generator=f"pirate-sm {escape(__version__)}",
        recording=escape(report.recording),
        title=escape(report.title),
        outcome=outcome,
        kind=report.outcome,
        sign=sign,
        short=escape(report.summary[0] if report.summary else ""),
        style=f"{plot_style()}\n{page_style()}",
        summary="\n".join(_summary(report)),
        warnings="\n".join(_warning(line) for line in report.warnings),
        story="\n".join(_story(report)),
        robot=_robot(report.scene),
        strip=strip(report),
        seen=seen_words(report.photos),
        diagram=report.diagram,
        facts="\n".join(_facts(report)),
        duration=f"{report.duration_s:.3f}",
        step=f"{_step(report.duration_s):g}",
        speeds="".join(_speed(each) for each in _SPEEDS),
        data=_inside_script(report_json(report)),
        space=(PAGE / "space.html").read_text("utf-8") if in_space else "",
        library="\n".join(libraries),
        script=f"(() => {{\n'use strict';\n{script}\n}})();",
    )


def _warning(line: str) -> str:
    return f'<p class="warning"><span aria-hidden="true">!</span> {escape(line)}</p>'


def _summary(report: Report) -> Iterable[str]:
    """Return the summary with the failures, without the first sentence, which the header has."""
    lines = [f"<p>{escape(line)}</p>" for line in report.summary[1:]]
    return [*lines[:1], *map(_failure, report.failures), *lines[1:]]


def _failure(failure: Sentence) -> str:
    where = f"in <b>{escape(failure.topic)}</b>: " if failure.topic else ""
    return (
        f'<p class="cause"><button type="button" data-at="{failure.before_s:.3f}">'
        f'{failure.at_s:.2f} s</button> <span><span class="sign" aria-hidden="true">✗</span> '
        f"{where}{escape(failure.text)}</span></p>"
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
        for name, view in zip(("scene", "scene-side"), scene.views, strict=True)
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
