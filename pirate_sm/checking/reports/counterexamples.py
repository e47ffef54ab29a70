"""Write counterexamples: the mission, and a trace script that reproduces the finding.

pirate-run DIR/NAME.yaml --backend trace --no-check --script DIR/NAME.script.yaml
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from math import isnan
from pathlib import Path
from shlex import quote
from typing import Any

import yaml

from pirate_sm.checking.exploring.exploration import Exploration, ExploredStep, sentence
from pirate_sm.checking.exploring.possible_events import UNSAID
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.check_mission import MissionCheck
from pirate_sm.core import library
from pirate_sm.core.documents import Document
from pirate_sm.core.documents import Path as At
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import FaultReport
from pirate_sm.core.expressions import Vocabulary
from pirate_sm.core.loading import TOLERABLE, LoadedMission
from pirate_sm.core.units import format_quantity
from pirate_sm.robot.backends.trace_script import UNKNOWN

SCRIPT_SUFFIX = ".script.yaml"

_NO_NAME = re.compile(r"[^A-Za-z0-9_.-]+")
_HAPPENS = {"failed": "not_done"}


def write_counterexample(
    finding: Finding, check: MissionCheck, folder: Path, name: str, path: Path, options: str = ""
) -> Finding:
    """Write the counterexample of a finding, and return the finding with the script's name.

    A finding without an event sequence, or of a mission that does not load, is returned unchanged.

    Args:
        finding: A finding of the check.
        check: The result of the check.
        folder: The target folder, which is created if necessary.
        name: Name of the mission's file and of the script.
        path: The checked mission.
        options: Further options of the check, for the command that runs the counterexample.

    Raises:
        OSError: The folder is not writable.
    """
    refused = any(each.code in TOLERABLE for each in check.findings)
    if check.loaded is None or refused or not finding.course:
        return finding
    folder.mkdir(parents=True, exist_ok=True)
    mission, script = folder / f"{name}.yaml", folder / f"{name}{SCRIPT_SUFFIX}"
    mission.write_text(_moved(check.loaded, path, folder), encoding="utf-8")
    command = (
        f"pirate-run {quote(str(mission))} --backend trace --no-check --script {quote(str(script))}"
    )
    head = [f"{finding.place}: {finding.code}", finding.message, "", f"{command} {options}".strip()]
    head += ["", *(f"{number}. {each}" for number, each in enumerate(finding.story, 1))]
    lines = (line for part in head for line in part.splitlines() or [""])
    comment = "".join(f"# {line}".rstrip() + "\n" for line in lines)
    script.write_text(comment + course_text(*finding.course[0]), encoding="utf-8")
    return replace(finding, example=str(script))


def course_text(found: Exploration, step: int) -> str:
    """Return the script of a trace in which everything happens that leads to this step."""
    course = [_happening(found, each) for each in found.path(step)]
    whole = {"format": 1, "course": course}
    return yaml.safe_dump(whole, allow_unicode=True, sort_keys=False, width=100)


def usual_name(finding: Finding) -> str:
    """Return the preferred name of a finding's counterexample."""
    place = f"{Path(finding.place.file).stem}-{finding.place.line}-{finding.place.column}"
    return _NO_NAME.sub("_", f"{place}-{finding.code}")


def _happening(found: Exploration, step: ExploredStep) -> dict[str, Any]:
    move = step.move
    entry: dict[str, Any] = {"happens": _HAPPENS.get(move.kind, move.kind)}
    if move.kind in {"answer", "fault"}:
        entry[move.kind] = move.word
    if isinstance(move.event, FaultReport):
        if move.event.message != UNSAID:
            entry["message"] = move.event.message
        if move.event.of:
            entry["of"] = list(move.event.of)
    answer = step.moment.answer
    signals = _signals(found.robot.vocabulary.with_changes, answer.numbers, answer.words)
    if signals:
        entry["signals"] = signals
    entry["what"] = sentence(found, step)
    return entry


def _signals(
    vocabulary: Vocabulary, numbers: Mapping[str, float], words: Mapping[str, str | None]
) -> dict[str, str]:
    found = {name: word or UNKNOWN for name, word in words.items()}
    return found | {
        name: UNKNOWN if isnan(value) else format_quantity(value, vocabulary.dimension(name))
        for name, value in numbers.items()
    }


def _moved(loaded: LoadedMission, path: Path, folder: Path) -> str:
    """Return the mission's text with the paths of other files relative to the new folder."""
    document = loaded.documents[0]
    beside = path.resolve().parent
    lines = document.text.splitlines(keepends=True)
    for at, name, target in _named(document, loaded, beside):
        if target.resolve().is_relative_to(library.shipped()):
            continue
        place = document.place_of(at)
        line = lines[place.line - 1]
        before, after = line[: place.column - 1], line[place.column - 1 :]
        new = os.path.relpath(target.resolve(), folder.resolve())
        new = new if "/" in new else f"./{new}"
        lines[place.line - 1] = before + after.replace(name, new, 1)
    return "".join(lines)


def _named(
    document: Document, loaded: LoadedMission, beside: Path
) -> Iterator[tuple[At, str, Path]]:
    """Yield each reference to another file: its path in the document, its text, and the file."""
    data = document.data
    yield ("robot",), data["robot"], loaded.loaded_robot.folder
    if isinstance(data.get("pipe"), str):
        yield ("pipe",), data["pipe"], library.find_pipe(data["pipe"], beside)
    for at, name in _calls(data, ()):
        yield at, name, library.find_mission(name, beside)


def _calls(data: Any, at: At) -> Iterator[tuple[At, str]]:
    if isinstance(data, dict):
        for key, value in data.items():
            if key == "call" and isinstance(value, str):
                yield (*at, key), value
            else:
                yield from _calls(value, (*at, key))
    elif isinstance(data, list):
        for number, value in enumerate(data):
            yield from _calls(value, (*at, number))


class Examples:
    """Stores the data for counterexamples until the final findings are known.

    Args:
        folder: The target folder, which is created with the first counterexample.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._checks: dict[int, tuple[MissionCheck, Path, str]] = {}  # by identity of explorations

    def remember(self, check: MissionCheck, path: Path, options: str) -> None:
        """Store the data for counterexamples of a mission's findings.

        Args:
            check: The result of the check.
            path: The mission's file.
            options: Options of a run that corresponds to the check.
        """
        for finding in check.findings:
            for found, _ in finding.course:
                self._checks[id(found)] = (check, path, options)

    def write(self, findings: Iterable[Finding]) -> list[Finding]:
        """Write a counterexample for every finding with an event sequence that is not allowed.

        Raises:
            UsageError: The folder is not writable.
        """
        try:
            return list(self._written(findings))
        except OSError as error:
            raise UsageError(f"'{self._folder}' cannot be written: {error.strerror}") from None

    def _written(self, findings: Iterable[Finding]) -> Iterator[Finding]:
        taken: set[str] = set()
        for finding in findings:
            known = self._checks.get(id(finding.course[0][0])) if finding.course else None
            if known is None or finding.allowed:
                yield finding
                continue
            check, path, options = known
            name = _free(usual_name(finding), taken)
            yield write_counterexample(finding, check, self._folder, name, path, options)


def _free(name: str, taken: set[str]) -> str:
    """Return a unique name, and add it to the used names."""
    free, number = name, 1
    while free in taken:
        number += 1
        free = f"{name}-{number}"
    taken.add(free)
    return free
