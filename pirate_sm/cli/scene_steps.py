"""Judges the command lines of scenes, which may come from anybody, by each command's parser."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import typer

from pirate_sm.checking import permissions
from pirate_sm.cli.entry import commands
from pirate_sm.cli.options.declaring import read_settings
from pirate_sm.core import library
from pirate_sm.core.documents import LoadError
from pirate_sm.core.documents import Path as Keys
from pirate_sm.core.errors import PirateError, RecordingError, UsageError
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.on_disk import asks_elsewhere
from pirate_sm.core.spelling import unknown
from pirate_sm.lab.campaign.campaign_model import SceneStep
from pirate_sm.lab.gallery.scene_file import ASKS, OUT, UNKNOWN, recording_of, words_of
from pirate_sm.robot.camera_file import opened_by
from pirate_sm.running.recording.read.reader import read_recording

_UNUSABLE: Any = typer.BadParameter.__base__
"""What the parser of a command raises for anything on a command line that cannot be used."""

_PRINTS = {"--help", "-h", "--version"}


def why_unplayable(step: SceneStep, folders: Mapping[str, Path]) -> Iterator[tuple[str, Keys, str]]:
    """Yield why a step of a scene cannot be played: the code, the keys and the message.

    Args:
        step: The step.
        folders: The scene's folders by their names.
    """
    words = words_of(step, folders)
    if why := why_refused(words, folders[OUT]):
        yield ASKS, ("command",), why
    elif words[0] == "run":
        yield from _unknown(step, _given("run", words[1:]), folders[OUT])


def _unknown(step: SceneStep, given: dict[str, Any], own: Path) -> Iterator[tuple[str, Keys, str]]:
    """Yield what a run and its step name that is not there; nothing where its files have faults."""
    name = given.get("mission")
    if name is None or permissions.is_below(Path(name), own):
        return  # resumed, or written by a step before
    try:
        path = library.find_mission(name)
        chosen = {key: given[key] for key in ("robot", "pipe") if key in given}
        loaded = load_mission(path, settings=read_settings(given.get("settings", ())), **chosen)
    except LoadError:
        return
    except UsageError as error:
        yield UNKNOWN, ("command",), str(error)
        return
    yield from ((UNKNOWN, ("command",), why) for why in _defects(loaded, given))
    phases = loaded.program.phases
    if step.power_cut_in is not None and step.power_cut_in not in phases:
        why = unknown("there is no phase", [step.power_cut_in], phases)
        yield UNKNOWN, ("power_cut_in",), why
    codes = loaded.robot.fault_codes
    for number, code in enumerate(step.expect.faults):
        if code not in codes:
            why = unknown("there is no fault", [code], codes)
            yield UNKNOWN, ("expect", "faults", number), why


def _defects(loaded: LoadedMission, given: dict[str, Any]) -> Iterator[str]:
    from pirate_sm.simulation.defects import named  # needs the simulator

    try:
        named(given.get("defects") or (), loaded.loaded_robot.profile, seed=0)
    except UsageError as error:
        yield str(error)


def why_refused(words: Sequence[str], own: Path) -> str:
    """Return why a scene may not run a command line; empty if it may.

    Args:
        words: The command line after ``pirate``, with its folders filled in.
        own: The scene's folder for output, below which alone it may write.
    """
    return "; ".join(_refusals(words, own))


def _refusals(words: Sequence[str], own: Path) -> Iterator[str]:
    name = words[0] if words else ""
    allowed = permissions.SCENES.get(name)
    if allowed is None:
        yield f"a scene cannot run the command '{name}', only {', '.join(permissions.SCENES)}"
        return
    if _PRINTS.intersection(words):
        yield f"a scene cannot ask for {', '.join(sorted(_PRINTS.intersection(words)))}"
        return
    try:
        given = _given(name, list(words[1:]))
    except _UNUSABLE as error:
        yield f"this command line cannot be used: {error.format_message()}"
        return
    for option in sorted(given.keys() - allowed):
        yield f"a scene cannot give '{name}' the option {_written(name, option)}"
    for place in _texts(given, permissions.WRITES.get(name, ())):
        if not permissions.is_below(Path(place), own):
            yield f"a scene writes below its own folder, {{out}}, not to '{place}'"
    if name == "run":
        yield from _reached(given)
        if given.get("record") != (str(recording_of(list(words)) or "") or None):
            yield "a run has one recording, written as two words: --record {out}/run.mcap"


def _parser(name: str) -> Any:
    command: Any = typer.main.get_command(commands)
    return command.get_command(None, name)


def _written(name: str, option: str) -> str:
    """Return how an option is written, of which the name of its field is known."""
    return next(str(each.opts[0]) for each in _parser(name).params if each.name == option)


def _given(name: str, words: list[str]) -> dict[str, Any]:
    """Return the options on a command line, by the names of their fields."""
    asks_elsewhere()  # the parser looks at files itself
    context = _parser(name).make_context(name, words)
    named = {each: context.get_parameter_source(each) for each in context.params}
    return {each: context.params[each] for each, it in named.items() if it.name == "COMMANDLINE"}


def _texts(given: dict[str, Any], names: Iterable[str]) -> Iterator[str]:
    for value in (given[name] for name in names if name in given):
        yield from (value if isinstance(value, list | tuple) else [str(value)])


def _reached(given: dict[str, Any]) -> Iterator[str]:
    """Yield what a run would reach outside this program."""
    backend, recorded = given.get("backend", "sim"), ""
    if given.get("resume"):
        try:
            header = read_recording(Path(given["resume"])).header
            backend, recorded = header.backend, str(header.options.get("detector") or "")
        except RecordingError:  # an earlier step writes it; it is asked again before it is resumed
            backend = "sim"
    if backend not in permissions.SIMULATED:
        yield f"a scene only simulates: the backend '{backend}' may reach a robot"
    for detector in (recorded, *_texts(given, ("detector", "also"))):
        try:
            opened = opened_by(detector, Path.cwd())
        except PirateError:  # the run itself says what is wrong with it
            opened = ""
        if opened:
            yield f"a scene only simulates: the detector '{detector}' opens {opened}"


def simulating(words: Sequence[str]) -> list[str]:
    """Return the command line of a step, in which no setting chooses a backend or a recording."""
    if words[0] != "run":
        return list(words)
    given = _given("run", list(words[1:]))
    backend = [] if given.keys() & {"backend", "resume"} else ["--backend", "sim"]
    recorded = [] if given.keys() & {"record", "no_record", "look"} else ["--no-record"]
    return [*words, *backend, *recorded]
