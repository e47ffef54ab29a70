"""A scene that was played: its result, what its file expects, and its page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from urllib.parse import quote

from pirate_sm.core.effects import Setpoints
from pirate_sm.core.errors import PirateError
from pirate_sm.core.models import SIMULATORS
from pirate_sm.lab.campaign.campaign_model import Expected, Scene, TrueEnd
from pirate_sm.lab.campaign.watched_run import judge, watched_run
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission, recorded_robot
from pirate_sm.running.wiring.resumed_run import recorded_order, with_folder
from pirate_sm.views.report.figure_page import FigureSection, figure_page
from pirate_sm.views.report.run_list import ListedRun, listed

# --- pages ---------------------------------------------------------------------------------------


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


# --- verdicts ------------------------------------------------------------------------------------


_WITH_TRUTH = SIMULATORS | {"bay"}
"""Backends that know the robot's true pose, and do the same again with the same seed."""


def unmet(expected: Expected, exit_code: int, output: str, recording: Path | None) -> list[str]:
    """Return what is not as expected, in sentences; nothing if all is.

    Args:
        expected: What the scene's file says.
        exit_code: The exit code of the step.
        output: What a command said that records nothing.
        recording: The recording of a run.
    """
    found = []
    if exit_code != expected.exit:
        found.append(f"exit code {exit_code}, expected {expected.exit}")
    if recording is None:
        if expected.says not in output:
            found.append(f"it does not say '{expected.says}'")
        return found
    try:
        read = read_recording(recording)
        found += [*_differences(expected, listed(read, "")), *_still_driven(read)]
        return [*found, *_not_held(expected, read)]
    except PirateError as error:
        return [*found, str(error)]


def _differences(expected: Expected, run: ListedRun) -> Iterator[str]:
    if expected.ended is not None and run.outcome != expected.ended:
        yield f"it ended {run.outcome}: {run.message}; expected {expected.ended}"
    if expected.says not in run.message:
        yield f"its end says '{run.message}', expected '{expected.says}'"
    for code in expected.faults:
        if code not in run.faults:
            yield f"the fault {code} was not reported, but {', '.join(run.faults) or 'none'}"


def _still_driven(recording: Recording) -> Iterator[str]:
    """Yield which motors the last setpoints drive that are at rest in the safe state."""
    robot, last = recorded_robot(recording.header), None
    for step in recording.steps():
        for effect in step.effects:
            if isinstance(effect, Setpoints):
                last = effect
    driven = [slot for slot in robot.safe_zero if last is not None and last.values[slot]]
    if driven:
        names = ", ".join(robot.slots[slot].name for slot in driven)
        yield f"it did not end in the safe state: {names} driven"


def _not_held(expected: Expected, recording: Recording) -> Iterator[str]:
    """Yield what is wrong with the robot's hold at the end, by the simulator's truth.

    A recording has no torques that a silent robot does not report, so the run is repeated with its
    seed. Runs that were resumed cannot be repeated alone, and those with a camera take too long.
    """
    header = recording.header
    with_camera = header.detector.partition(":")[0] == "vision"
    if header.resumed or with_camera or header.backend not in _WITH_TRUTH:
        return
    order = replace(recorded_order(header), backend=header.backend, check=False, panel=None)
    with recorded_mission(header) as loaded:
        outcome = watched_run(order, with_folder(loaded, header))
    ended = listed(recording, "").message
    if outcome.message != ended:
        yield f"repeated with its seed it ends otherwise: {outcome.message}"
        return
    verdict = judge(outcome, TrueEnd())
    if verdict.held != expected.held:
        slid = f"{outcome.slid_m * 1000:.0f} mm in two seconds"
        yield f"in truth it is {'held' if verdict.held else f'not held, and carried on by {slid}'}"
    if verdict.unsafe:
        yield f"in truth it does not end in the safe state: {verdict.unsafe}"
