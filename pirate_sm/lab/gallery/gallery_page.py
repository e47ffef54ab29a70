"""Pages of the gallery: a scene that was played, and the list of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from urllib.parse import quote

from pirate_sm.core.campaign import Scene
from pirate_sm.views.report.figure_page import FigureSection, figure_page

_STYLE = """<style>
.said { overflow-x: auto; margin: 6px 0; padding: 8px 10px; background: var(--ground);
        border: 1px solid var(--border); font-size: 12.5px; white-space: pre-wrap; }
.command { overflow-wrap: anywhere; }
.good { color: var(--good); font-weight: 600; }
.bad { color: var(--bad); font-weight: 600; }
.figures a { color: var(--path); }
</style>"""


@dataclass(frozen=True)
class PlayedStep:
    """A step that was played.

    Attributes:
        about: What happens in it.
        command: Its command line.
        unmet: What was not as expected.
        output: What it said, if it records nothing.
        report: Link to the report of its run; empty without one.
    """

    about: str
    command: str
    unmet: tuple[str, ...] = ()
    output: str = ""
    report: str = ""


@dataclass(frozen=True)
class PlayedScene:
    """A scene that was played, or why it was left out."""

    scene: Scene
    steps: tuple[PlayedStep, ...] = ()
    left_out: str = ""

    @property
    def unmet(self) -> tuple[str, ...]:
        """Return what was not as expected, in all steps."""
        return tuple(each for step in self.steps for each in step.unmet)


def scene_page(played: PlayedScene) -> str:
    """Return the page of a scene: what to look at, its steps, links to the reports of its runs."""
    scene = played.scene
    verdict = f'{_STYLE}<p class="{_kind(played)}">{escape(verdict_of(played))}</p>'
    steps = [
        FigureSection(f"Step {number}", [step.about] if step.about else [], markup=_step(step))
        for number, step in enumerate(played.steps, 1)
    ]
    return figure_page(
        scene.title, [FigureSection("What to look at", [scene.look_at], markup=verdict), *steps]
    )


def gallery_page(scenes: Sequence[PlayedScene]) -> str:
    """Return the list of the scenes, with a link to the page of each that was played."""
    sections = [
        FigureSection(
            each.scene.title,
            [each.scene.look_at],
            markup=f'<p class="{_kind(each)}">{escape(verdict_of(each))}</p>{_link(each)}',
        )
        for each in scenes
    ]
    first = FigureSection("Scenes", [f"{len(scenes)} scenes of pirate demo."], markup=_STYLE)
    return figure_page("The gallery", [first, *sections])


def verdict_of(played: PlayedScene) -> str:
    """Return in a line how a scene ended."""
    if played.left_out:
        return f"– left out: {played.left_out}"
    if played.unmet:
        return f"✗ not as expected: {'; '.join(played.unmet)}"
    return "✓ as expected"


def _kind(played: PlayedScene) -> str:
    return "bad" if played.unmet else "hint" if played.left_out else "good"


def _step(step: PlayedStep) -> str:
    parts = [f'<p class="command"><code>$ {escape(step.command)}</code></p>']
    parts += [f'<p class="bad">✗ {escape(each)}</p>' for each in step.unmet]
    if step.output:
        parts.append(f'<pre class="said" tabindex="0">{escape(step.output)}</pre>')
    if step.report:
        parts.append(f'<p><a href="{escape(quote(step.report))}">The report of this run</a></p>')
    return "".join(parts)


def _link(played: PlayedScene) -> str:
    if played.left_out:
        return ""
    page = f"{played.scene.scene}/index.html"
    links = [f'<a href="{escape(quote(page))}">The scene {escape(played.scene.scene)}</a>']
    for number, step in enumerate(played.steps, 1):
        if step.report:
            place = quote(f"{played.scene.scene}/{step.report}")
            links.append(f'<a href="{escape(place)}">report of step {number}</a>')
    return f"<p>{', '.join(links)}</p>"
