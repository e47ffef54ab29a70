"""`pirate demo`: plays scenes of the gallery, judges them, and writes their pages."""

from __future__ import annotations

import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from pirate_sm.checking.permissions import is_below
from pirate_sm.cli.errors import say
from pirate_sm.cli.options.declaring import read_speed
from pirate_sm.cli.options.running import DemoOptions
from pirate_sm.cli.output.files import refuse_losses, write_file
from pirate_sm.cli.output.terminal import columns_of, is_terminal, wrapped
from pirate_sm.cli.scene_steps import simulating, why_refused, why_unplayable
from pirate_sm.core import library
from pirate_sm.core.effects import PhaseChange
from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.core.visible import visible
from pirate_sm.lab.campaign.campaign_model import Scene, SceneStep
from pirate_sm.lab.experiments.needed_extras import is_missing
from pirate_sm.lab.gallery.scene_file import (
    HERE,
    OUT,
    load_scene,
    recording_of,
    without_recording,
    words_of,
)
from pirate_sm.running.recording.read.reader import read_recording

if TYPE_CHECKING:
    from pirate_sm.lab.gallery.played_scene import PlayedScene, PlayedStep

AS_EXPECTED, NOT_SO = 0, 1
PAGE = "index.html"

_THIS_PROGRAM = "from pirate_sm.cli.start import main; main()"
_CUT_OFF_SPEED = "8"
"""Speed of a run that a power cut ends, where all others run at full speed: it needs the time."""

_LOOK_EVERY_S = 0.1
_PATIENCE_S = 120.0
"""Longest time until the phase of a power cut is reached."""


class DemoStoppedError(Exception):
    """Somebody has pressed Ctrl-C or ended the demo; the run under way has ended.

    Attributes:
        number: The signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def play_demo(options: DemoOptions) -> int:
    """List the scenes, or play one or all; return the exit code.

    Raises:
        LoadError: A scene's file has errors.
        UsageError: There is no such scene, an extra is missing, or a page cannot be written or
            would overwrite somebody's work.
    """
    if options.speed is not None:
        read_speed(options.speed, 1.0)
    if options.all and options.scene is not None:
        raise UsageError("--all plays every scene: name none")
    try:
        if options.all:
            return _play_all(options)
        if options.scene is not None:
            return _play_one(library.find_scene(options.scene), options)
    except DemoStoppedError as stopped:
        say("interrupted" if stopped.number == signal.SIGINT else "stopped")
        return 128 + stopped.number
    _list()
    return AS_EXPECTED


def _list() -> None:
    """Print the scenes and how to play one."""
    scenes = [load_scene(path) for path in library.scenes()]
    wide = max(len(each.scene) for each in scenes)
    for each in scenes:
        missing = _missing(each)
        said = visible(f"  {each.scene:<{wide}}  {each.title}{f' ({missing})' if missing else ''}")
        print(wrapped(said, columns_of(), wide + 4))
    print("\nplay one: pirate demo SCENE   all at full speed: pirate demo --all")


def _missing(scene: Scene) -> str:
    """Return which extra is missing and how to get it; empty if none is."""
    return "; ".join(filter(None, map(is_missing, scene.needs)))


def _play_one(path: Path, options: DemoOptions) -> int:
    from pirate_sm.lab.gallery.played_scene import verdict_of

    scene = _loaded(path, options.output)
    if missing := _missing(scene):
        raise UsageError(f"the scene {scene.scene} cannot be played: {missing}")
    refuse_losses([options.output / scene.scene / PAGE], overwrite=options.overwrite)
    speed = options.speed or f"{scene.speed:g}"
    played = _play(scene, path, options.output, speed)
    print(visible(verdict_of(played)))
    print(visible(f"report: {options.output / scene.scene / PAGE}"))
    return NOT_SO if played.unmet else AS_EXPECTED


def _loaded(path: Path, output: Path) -> Scene:
    """Return a scene, none of whose steps asks for what a scene may not have.

    Raises:
        LoadError: Its file has errors.
    """
    folders = _folders(path, output)
    return load_scene(path, lambda step: why_unplayable(step, folders))


def _folders(path: Path, output: Path) -> dict[str, Path]:
    return {OUT: output / path.stem, HERE: _near(path.parent)}


def _play_all(options: DemoOptions) -> int:
    from pirate_sm.lab.gallery.played_scene import PlayedScene, gallery_page, verdict_of

    scenes, known = [], [(path, _loaded(path, options.output)) for path in library.scenes()]
    pages = [options.output / scene.scene / PAGE for _, scene in known]
    refuse_losses([options.output / PAGE, *pages], overwrite=options.overwrite)
    for path, scene in known:
        missing = _missing(scene)
        if missing:
            played = PlayedScene(scene, left_out=missing)
        else:
            played = _play(scene, path, options.output, options.speed or "max", quiet=True)
        print(visible(f"{scene.scene}: {verdict_of(played)}"), flush=True)
        scenes.append(played)
    write_file(options.output / PAGE, gallery_page(scenes))
    print(visible(f"report: {options.output / PAGE}"))
    return NOT_SO if any(each.unmet for each in scenes) else AS_EXPECTED


def _play(
    scene: Scene, path: Path, output: Path, speed: str, *, quiet: bool = False
) -> PlayedScene:
    """Play the steps of a scene and write its page; ``quiet``: of runs only how they ended."""
    from pirate_sm.lab.gallery.played_scene import PlayedScene, scene_page

    folder = output / scene.scene
    if not is_below(folder, output):
        raise UsageError(f"'{folder}' leads out of '{output}'; name another folder with --output")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = f"'{folder}' cannot be made: {error.strerror}"
        raise UsageError(f"{why}; name another folder with --output") from None
    about = visible(f"{scene.title}\n\n{scene.look_at.strip()}", lines=True)
    print("\n".join(wrapped(line, columns_of(), 0) for line in about.splitlines()), flush=True)
    folders = _folders(path, output)
    more = ["--speed", speed, *(["--quiet"] if quiet else [])]
    steps = [_play_step(step, words_of(step, folders), folder, more) for step in scene.steps]
    played = PlayedScene(scene, tuple(steps))
    write_file(folder / PAGE, scene_page(played))
    return played


def _near(folder: Path) -> Path:
    """Return the path of a folder, from the working directory if it is below that."""
    whole, here = folder.resolve(), Path.cwd()
    return whole.relative_to(here) if whole.is_relative_to(here) else whole


def _play_step(step: SceneStep, words: list[str], folder: Path, of_a_run: list[str]) -> PlayedStep:
    from pirate_sm.lab.gallery.played_scene import PlayedStep, unmet

    if why := why_refused(words, folder):  # an earlier step may have written what it reads
        raise UsageError(why)
    recording = recording_of(words)
    if recording is not None:
        recording.unlink(missing_ok=True)  # of the last time that the scene was played
    words = simulating(words)
    if words[0] == "run":
        words = [*words, *of_a_run]
    if step.power_cut_in is not None and "max" in words:
        words[words.index("max")] = _CUT_OFF_SPEED
    command = shlex.join(["pirate", *without_recording(words)])
    about = f"\n{step.about}" if step.about else ""
    print(visible(f"{about}\n$ {command}", lines=True), flush=True)
    if step.power_cut_in is not None:
        assert recording is not None
        problems, output = _cut_off(words, recording, step.power_cut_in), ""
    else:
        code, output = _run(words, shows=recording is not None)
        problems = unmet(step.expect, code, output, recording)
    report = _report(recording, folder) if recording is not None else ""
    return PlayedStep(step.about or "", command, tuple(problems), output, report)


def _run(words: list[str], *, shows: bool) -> tuple[int, str]:
    """Run a command line of this program; return its exit code and what it said.

    Args:
        words: The command line after ``pirate``.
        shows: Whether it has the terminal to itself; then what it says is not known.

    Raises:
        StoppedError: Somebody has stopped it or the demo.
    """
    kept = subprocess.PIPE if not shows else None
    with _started(words, stdout=kept, stderr=subprocess.STDOUT if kept else None) as process:
        said, _ = process.communicate()
    output = said or ""
    if output:
        print(visible(output.rstrip(), lines=True), flush=True)
    return process.returncode, output


def _cut_off(words: list[str], recording: Path, phase: str) -> list[str]:
    """Run a mission and kill it when it is in this phase; return what went wrong."""
    deadline_s = monotonic() + _PATIENCE_S
    with _started(words) as process:
        try:
            while process.poll() is None and not _is_in(recording, phase):
                if monotonic() > deadline_s:
                    return [f"the mission did not come to {phase}"]
                sleep(_LOOK_EVERY_S)
        finally:
            process.kill()
    if process.returncode != -signal.SIGKILL:
        return [f"the run was over before the power cut, with exit code {process.returncode}"]
    if is_terminal(sys.stdout):
        print("\x1b[?25h", end="")  # the view had hidden the cursor
    print(f"\n… and the power is cut in the phase {phase}", flush=True)
    return []


def _is_in(recording: Path, phase: str) -> bool:
    """Return whether what is on the disk of a run says that it has come to this phase."""
    try:
        steps = read_recording(recording).steps()
        return any(
            isinstance(effect, PhaseChange) and effect.phase == phase
            for step in steps
            for effect in step.effects
        )
    except RecordingError:  # not begun yet
        return False


@contextmanager
def _started(words: list[str], **pipes: Any) -> Iterator[subprocess.Popen[str]]:
    """Yield a process with a command line of this program, which alone answers Ctrl-C.

    The terminal sends Ctrl-C to it as well; it ends in the safe state, and this process waits for
    it. Other requests to stop are handed on.

    Raises:
        StoppedError: Somebody has stopped it or the demo, however it has ended then: while it
            starts, the signal itself ends it.
    """
    process: subprocess.Popen[str] | None = None
    asked: list[int] = []

    def hand_on(number: int, frame: object) -> None:
        asked.append(number)
        if process is not None and number != signal.SIGINT:
            process.send_signal(number)

    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, hand_on) for number in numbers}
    try:
        process = subprocess.Popen(
            [sys.executable, "-c", _THIS_PROGRAM, *words], text=True, **pipes
        )
        for number in asked:  # it was not there yet
            process.send_signal(number)
        yield process
    finally:
        if process is not None:
            process.wait()
        for number, handler in before.items():
            signal.signal(number, handler)
    if process.returncode in (-signal.SIGINT, 128 + signal.SIGINT):
        asked.append(signal.SIGINT)
    if asked:
        raise DemoStoppedError(asked[0])


def _report(recording: Path, folder: Path) -> str:
    """Write the report of a run; return its name, empty if the plotting library is missing."""
    from pirate_sm.views.report.recording_report import report_of
    from pirate_sm.views.report.report_page import html

    try:
        page = recording.with_suffix(".html")
        if not is_below(page, folder):
            raise UsageError(f"'{page}' leads out of the scene's folder, so it stays")
        write_file(page, html(report_of(read_recording(recording))))
    except (RecordingError, UsageError) as error:
        say(str(error))
        return ""
    return page.relative_to(folder).as_posix()
