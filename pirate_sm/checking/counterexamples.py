"""A counterexample as files: the mission, and a script that makes a trace run into the finding.

pirate-run DIR/NAME.yaml --backend trace --no-check --script DIR/NAME.script.yaml
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import Any

import yaml

from pirate_sm.checking.exploring.explorer import Exploration, Step
from pirate_sm.checking.exploring.story import sentence
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission import MissionCheck
from pirate_sm.expressions import NumberType, Vocabulary
from pirate_sm.loading import library
from pirate_sm.loading.mission import TOLERABLE, LoadedMission
from pirate_sm.loading.problems import Path as At
from pirate_sm.loading.source import Document
from pirate_sm.model.course import UNKNOWN
from pirate_sm.units import DIMENSIONLESS, format_quantity

_NO_NAME = re.compile(r"[^A-Za-z0-9_.-]+")
_HAPPENS = {"failed": "not_done"}


def write_counterexamples(
    check: MissionCheck, folder: Path, path: Path, options: str = ""
) -> MissionCheck:
    """Every finding that a course of events leads to has its files; it names them as its example.

    Args:
        check: What was found.
        folder: Where to; made if need be.
        path: The mission's file.
        options: Further options that the mission was checked with, for the command to run.

    Raises:
        OSError: The folder cannot be written.
    """
    refused = any(each.code in TOLERABLE for each in check.findings)
    if check.loaded is None or refused:  # a mission that does not load cannot be run
        return check
    findings = tuple(
        _written(each, check.loaded, folder, path, options) if each.course else each
        for each in check.findings
    )
    return replace(check, findings=findings)


def _written(
    finding: Finding, loaded: LoadedMission, folder: Path, path: Path, options: str
) -> Finding:
    folder.mkdir(parents=True, exist_ok=True)
    place = f"{Path(finding.place.file).stem}-{finding.place.line}-{finding.place.column}"
    name = _NO_NAME.sub("_", f"{place}-{finding.code}")
    mission, script = folder / f"{name}.yaml", folder / f"{name}.script.yaml"
    mission.write_text(_moved(loaded, path, folder), encoding="utf-8")
    command = f"pirate-run {mission} --backend trace --no-check --script {script}"
    head = [f"{finding.place}: {finding.code}", finding.message, "", f"{command} {options}".strip()]
    head += ["", *(f"{number}. {each}" for number, each in enumerate(finding.story, 1))]
    comment = "".join(f"# {line}".rstrip() + "\n" for line in head)
    found, number = finding.course[0]
    course = [_happening(found, step) for step in found.path(number)]
    text = yaml.safe_dump(
        {"format": 1, "course": course}, allow_unicode=True, sort_keys=False, width=100
    )
    script.write_text(comment + text, encoding="utf-8")
    return replace(finding, example=name)


def _happening(found: Exploration, step: Step) -> dict[str, Any]:
    move = step.move
    entry: dict[str, Any] = {"happens": _HAPPENS.get(move.kind, move.kind)}
    if move.kind in {"answer", "fault"}:
        entry[move.kind] = move.word
    answer = step.moment.answer
    signals = _signals(found.robot.vocabulary, answer.numbers, answer.words)
    if signals:
        entry["signals"] = signals
    entry["what"] = sentence(found, step)
    return entry


def _signals(
    vocabulary: Vocabulary, numbers: Mapping[str, float], words: Mapping[str, str | None]
) -> dict[str, str]:
    found = {name: word or UNKNOWN for name, word in words.items()}
    for name, value in numbers.items():
        kind = vocabulary.types[name]
        dimension = kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS
        found[name] = UNKNOWN if isnan(value) else format_quantity(value, dimension)
    return found


def _moved(loaded: LoadedMission, path: Path, folder: Path) -> str:
    """The mission's text with every file that it names by a path found from the new folder."""
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
    """Where the mission names another file, by which name, and that file."""
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
