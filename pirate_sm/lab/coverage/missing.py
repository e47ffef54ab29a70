"""Find runs that take the branches that no run has taken, and write them as a scene.

The simulator is tried first: as the files say, then with each known defect of the robot, from the
start and from each phase on. For what remains the exploration knows the events, if any lead there,
and they become the script of a trace. Only runs that were run and have taken a branch are written.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import yaml

from pirate_sm.api import Run
from pirate_sm.checking.exploring.exploration import Exploration
from pirate_sm.checking.reports.counterexamples import SCRIPT_SUFFIX, course_text
from pirate_sm.core.branches import branches
from pirate_sm.core.documents import parse_document
from pirate_sm.core.effects import PhaseChange
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.options import keys_of_defect
from pirate_sm.core.program import BranchKey
from pirate_sm.lab.campaign.campaign_model import TrueEnd
from pirate_sm.lab.campaign.watched_run import judge, watched_run
from pirate_sm.lab.coverage.evidence import Played, Taken, names_of_commands, played, taken_in
from pirate_sm.robot.backends import trace_script
from pirate_sm.running.wiring import Order

_AFTER_S = 0.5
"""A defect begins so long after the phase in which it is to matter [decided]: its commands are
under way then."""


@dataclass(frozen=True)
class FoundRehearsal:
    """A run that takes branches which no run has taken before.

    Attributes:
        order: What is run.
        played: The run.
        taken: All that it has taken.
        takes: The branches for which it was kept.
        script: The script of a trace, as text; empty in the simulator.
    """

    order: Order
    played: Played
    taken: Taken
    takes: tuple[BranchKey, ...]
    script: str = ""


def rehearsals(
    plain: Order,
    loaded: LoadedMission,
    untaken: Collection[BranchKey],
    untraced: Collection[BranchKey],
    found: Exploration,
    tries: int,
    watch: Callable[[float], None] = lambda share: None,
) -> Iterator[FoundRehearsal]:
    """Yield runs that take missing branches, until all are taken or nothing more is known.

    Args:
        plain: The mission with its options, in the simulator.
        loaded: The mission.
        untaken: Its branches that neither a simulated nor a real robot has taken.
        untraced: Those of them that no trace has taken either.
        found: Its exploration.
        tries: How many runs in the simulator are tried.
        watch: Receives the share of the tries that are done.
    """
    left = set(untaken)
    for tried, order in enumerate(_orders(plain, loaded) if loaded.pipe is not None else ()):
        if not left or tried >= tries:
            break
        watch(tried / tries)
        try:
            ended = played(order, loaded)
        except UsageError:  # a defect that needs more than its name
            continue
        yield from _kept(FoundRehearsal(order, ended, taken_in(ended.run), ()), left)
    for key in sorted(left.intersection(untraced)):
        if key in left and (step := found.taken.get(key)) is not None and found.is_playable(step):
            script = course_text(found, step)
            course = trace_script.read_script(parse_document(script, "a script")).course
            order = replace(plain, backend="trace", course=course)
            ended = played(order, loaded)
            yield from _kept(FoundRehearsal(order, ended, taken_in(ended.run), (), script), left)


def _kept(it: FoundRehearsal, left: set[BranchKey]) -> Iterator[FoundRehearsal]:
    """Yield a run if it takes what is left, and take that out."""
    takes = tuple(key for key in it.taken.branches if key in left)
    if takes and it.played.run.outcome != "interrupted":
        left.difference_update(takes)
        yield replace(it, takes=takes)


def _orders(plain: Order, loaded: LoadedMission) -> Iterator[Order]:
    """Yield runs in the simulator: without a defect, then with each, then from each phase on."""
    yield plain
    defects = loaded.loaded_robot.profile.simulation.defects
    for name in defects:
        yield replace(plain, defects=(name,))
    begins_s = sorted(set(_begins_s(played(plain, loaded).run)))
    timed = [name for name, each in defects.items() if "after" in keys_of_defect(each.kind)]
    for at_s in begins_s:
        for name in timed:
            yield replace(plain, defects=(f"{name}:after={at_s + _AFTER_S:.1f}s",))


def _begins_s(run: Run) -> Iterator[float]:
    """Yield when each phase begins."""
    for step in run.steps():
        if any(isinstance(each, PhaseChange) for each in step.effects):
            yield round(step.at_s - run.origin_s, 1)


# --- a scene --------------------------------------------------------------------------------------


def scene_file(folder: Path, mission: Path) -> Path:
    """Return the file of the scene of a mission's rehearsals in a folder."""
    return folder / f"{mission.stem}_branches.yaml"


def written_files(folder: Path, mission: Path) -> list[Path]:
    """Return what :func:`write_scene` may replace: the scene, and scripts that are there."""
    scene = scene_file(folder, mission)
    numbered = re.compile(rf"{re.escape(scene.stem)}_\d+{re.escape(SCRIPT_SUFFIX)}")
    there = sorted(folder.glob(f"*{SCRIPT_SUFFIX}"))
    return [scene, *(each for each in there if numbered.fullmatch(each.name))]


def write_scene(
    folder: Path,
    path: Path,
    loaded: LoadedMission,
    found: Iterable[FoundRehearsal],
) -> Path:
    """Write a mission's rehearsals as a scene, with the scripts of its traces, and return its file.

    Args:
        folder: The target folder, which is created if necessary.
        path: The mission's file.
        loaded: The mission.
        found: The rehearsals.

    Raises:
        OSError: The folder is not writable.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file = scene_file(folder, path)
    name, known = file.stem, branches(loaded.program, names_of_commands(loaded))
    mission = f"{{here}}/{os.path.relpath(path.resolve(), folder.resolve())}"
    steps = []
    for number, each in enumerate(found, 1):
        order = replace(each.order, mission=mission, course=())
        line = ["run", *order.command()]
        if each.script:
            script = f"{name}_{number}{SCRIPT_SUFFIX}"
            (folder / script).write_text(each.script, encoding="utf-8")
            line += ["--script", f"{{here}}/{script}"]
        line += ["--record", f"{{out}}/{number}.mcap"]
        expect = {"exit": each.played.exit_code, "ended": each.played.run.outcome}
        if not each.script:
            expect["held"] = judge(watched_run(each.order, loaded), TrueEnd()).held
        about = "; ".join(known[key].words for key in each.takes)
        steps.append({"about": about, "command": " ".join(map(_word, line)), "expect": expect})
    scene = {
        "format": 1,
        "scene": name,
        "title": f"Rehearsals of branches of {path.stem}",
        "look_at": "Each step takes the branches that it names.",
        "steps": steps,
    }
    text = yaml.safe_dump(scene, allow_unicode=True, sort_keys=False, width=100)
    file.write_text(text, encoding="utf-8")
    return file


_PLAIN = re.compile(r"[\w{}/.,:=@%+-]+")


def _word(word: str) -> str:
    """Return a word as a command line has it; the folders in braces stay readable."""
    return word if _PLAIN.fullmatch(word) else shlex.quote(word)
