"""Read scene files, and fill in the folders of their command lines."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TypeAlias

from pirate_sm.core.documents import Document, Problems, read_document
from pirate_sm.core.documents import Path as Keys
from pirate_sm.core.loading import validate
from pirate_sm.lab.campaign.campaign_model import Scene, SceneStep

OUT, HERE = "out", "here"
RECORD = "--record"
ASKS, UNKNOWN = "scene.asks", "scene.unknown"
_FOLDER = re.compile(r"\{([^{}]*)\}")

_SUCCEEDED = (0, 5)
"""Exit codes of missions that have succeeded, with an incomplete recording too."""

Refusal: TypeAlias = Callable[[SceneStep], Iterable[tuple[str, Keys, str]]]
"""Returns why a step cannot be played: for each reason its code, its keys and the message."""


def load_scene(path: Path, refusal: Refusal | None = None) -> Scene:
    """Return the scene in a file.

    Args:
        path: The file.
        refusal: Judges its command lines; needed before any of them is run.

    Raises:
        LoadError: The file has faults; holds all of them.
    """
    scene, _, problems = _read(path, refusal)
    problems.raise_errors()
    return scene


def check_scene(path: Path, refusal: Refusal) -> tuple[Document, Problems]:
    """Return the file of a scene, and what is wrong with it.

    Raises:
        LoadError: It cannot be read, or does not have the keys of a scene.
    """
    _, document, problems = _read(path, refusal)
    return document, problems


def _read(path: Path, refusal: Refusal | None) -> tuple[Scene, Document, Problems]:
    document = read_document(path)
    scene = validate(document, Scene)
    problems = Problems(document)
    if scene.scene != path.stem:
        message = f"the scene is called as its file: {path.stem}"
        problems.add("scene.name", ("scene",), message, expected=path.stem)
    before: set[str] = set()
    for number, step in enumerate(scene.steps):
        _check(step, problems, ("steps", number), refusal)
        _check_recordings(step, before, problems, ("steps", number, "command"))
    return scene, document, problems


def _check(step: SceneStep, problems: Problems, at: Keys, refusal: Refusal | None) -> None:
    """Report what is wrong with a step's command line."""
    path = (*at, "command")
    unknown = [name for name in _FOLDER.findall(step.command) if name not in (OUT, HERE)]
    for name in unknown:
        problems.add_unknown("scene.folder", path, "folder", name, (OUT, HERE))
    try:
        words = shlex.split(step.command)
    except ValueError as error:
        problems.add("scene.command", path, f"the command line cannot be read: {error}")
        return
    recorded, expected = RECORD in words[:-1], step.expect
    if expected.ended and (expected.ended == "succeeded") is (expected.exit not in _SUCCEEDED):
        how = expected.ended if expected.ended != "fault" else "ended with a fault"
        message = f"a run that has {how} does not end with exit code {expected.exit}"
        problems.add("scene.record", (*at, "expect", "ended"), message)
    if (step.power_cut_in or step.expect.ended or step.expect.faults) and not recorded:
        message = f"what becomes of a run is read in its recording: add {RECORD} {{{OUT}}}/run.mcap"
        if words[:1] != ["run"]:
            path, message = (*at, "expect"), "only a run has an end and faults: ask for `says` here"
        problems.add("scene.record", path, message)
        path = (*at, "command")
    if recorded and not words[words.index(RECORD) + 1].startswith(f"{{{OUT}}}/"):
        message = f"a scene records into its own folder: {RECORD} {{{OUT}}}/run.mcap"
        problems.add("scene.record", path, message)
        return
    if not unknown and refusal is not None:
        for code, keys, why in refusal(step):
            problems.add(code, (*at, *keys), why)


def _check_recordings(step: SceneStep, before: set[str], problems: Problems, at: Keys) -> None:
    """Report recordings that a step reads and no step before it writes; add its own words."""
    words = step.command.split()
    for option, word in zip(["", *words], words, strict=False):
        read = word.startswith(f"{{{OUT}}}/") and word.endswith(".mcap") and option[:1] != "-"
        if read and not any(word.startswith(each.removesuffix(".mcap")) for each in before):
            problems.add("scene.record", at, f"no step before this one records {word}")
    before |= {word for word in words if word.endswith(".mcap")}


def words_of(step: SceneStep, folders: Mapping[str, Path]) -> list[str]:
    """Return the words of a step's command line, with the folders filled in.

    Args:
        step: The step.
        folders: The folders by their names, ``out`` and ``here``.
    """
    return [_FOLDER.sub(lambda it: str(folders[it[1]]), each) for each in shlex.split(step.command)]


def recording_of(words: list[str]) -> Path | None:
    """Return the recording that a command line writes; None if it writes none."""
    return Path(words[words.index(RECORD) + 1]) if RECORD in words else None


def without_recording(words: list[str]) -> list[str]:
    """Return a command line that can be run again: its recording is there, and none is replaced."""
    if RECORD not in words:
        return words
    at = words.index(RECORD)
    return [*words[:at], *words[at + 2 :]]
