"""Determine the kind of a file from its text, even if the file is too broken to be read."""

from __future__ import annotations

import re
from enum import StrEnum
from pathlib import Path as FilePath

from pirate_sm.core._loading.file_names import PROFILE_FILE
from pirate_sm.core._loading.problems import LoadError, Problems
from pirate_sm.core._loading.yaml.document import LARGEST_FILE, Document
from pirate_sm.core.on_disk import opened


class FileKind(StrEnum):
    """The known kinds of files."""

    ROBOT = "robot"
    CHART = "chart"
    PIPE = "pipe"
    CALIBRATION = "calibration"
    CAMERA = "camera"
    PANEL = "panel"
    MISSION = "mission"
    SCRIPT = "trace script"
    EXPERIMENT = "experiment"
    TWIN = "twin"
    CAMPAIGN = "campaign"
    SCENE = "scene"
    UNREADABLE = "unreadable file"
    OTHER = "other file"


_TELLING = (
    (FileKind.CAMPAIGN, {"campaign"}),
    (FileKind.SCENE, {"scene", "steps"}),
    (FileKind.SCENE, {"scene", "title"}),
    (FileKind.MISSION, {"phases"}),
    (FileKind.MISSION, {"mission", "start"}),
    (FileKind.MISSION, {"mission", "robot"}),
    (FileKind.MISSION, {"mission", "ends"}),
    (FileKind.ROBOT, {"boards"}),
    (FileKind.ROBOT, {"body", "chart"}),
    (FileKind.ROBOT, {"robot", "chart"}),
    (FileKind.ROBOT, {"actuation"}),
    (FileKind.PIPE, {"segments"}),
    (FileKind.PIPE, {"pipe", "diameter"}),
    (FileKind.PIPE, {"pipe", "runs"}),
    (FileKind.PIPE, {"diameter", "runs"}),
    (FileKind.PIPE, {"runs", "junctions"}),
    (FileKind.CALIBRATION, {"robot", "zeros"}),
    (FileKind.EXPERIMENT, {"experiment"}),
    (FileKind.TWIN, {"robot", "motors"}),
    (FileKind.TWIN, {"robot", "friction"}),
    (FileKind.TWIN, {"robot", "joints"}),
    (FileKind.CAMERA, {"camera", "source"}),
    (FileKind.CAMERA, {"camera", "setup"}),
    (FileKind.PANEL, {"buttons"}),
    (FileKind.PANEL, {"panel", "controls"}),
)
"""Combinations of top-level keys that identify a kind of file; the first match decides."""

_ENTRY = {"phase", "trigger", "after"}
"""Keys of an entry of a trace script; two of them identify a script if a third is misspelt."""

_EXTENDS = re.compile(r"^extends[ \t]*:", re.MULTILINE)

_CONTENT = re.compile(r"^([ ]*)([^\s#%].*)$", re.MULTILINE)
_WORD = r"""["']?([A-Za-z_][A-Za-z0-9_]*)["']?[ \t]*:(?=\s|$)"""
_IN_BRACES = re.compile(r"""[\s{,]["']?([A-Za-z_][A-Za-z0-9_]*)["']?[ \t]*:""")


def kind_of(path: FilePath) -> FileKind:
    """Return the kind of the file."""
    text = _beginning(path)
    kind = FileKind.UNREADABLE if text is None else kind_of_text(text)
    extends = kind is FileKind.OTHER and path.name == PROFILE_FILE and _EXTENDS.search(text or "")
    return FileKind.ROBOT if extends else kind


def kind_of_text(text: str) -> FileKind:
    """Return the kind of a file with this text."""
    text = "\n".join(text.splitlines())  # a line may end in CR alone, which `^` does not know
    first = next((each for each in _CONTENT.finditer(text) if each[2].rstrip() != "---"), None)
    if first is None:
        return FileKind.OTHER
    if first[2].startswith(("-", "[")):
        return FileKind.SCRIPT if _lists_triggers(text) else FileKind.OTHER
    if first[2].startswith("{"):
        keys = set(_IN_BRACES.findall(text))
    else:
        keys = set(re.findall(f"^{first[1]}{_WORD}", text, re.MULTILINE))
    if "states" in keys and re.search(r"\bparallel\b", text):
        return FileKind.CHART
    if "trigger" in keys and keys <= _ENTRY:
        return FileKind.SCRIPT  # one entry, and the list is forgotten
    if "course" in keys and ("format" in keys or re.search(r"\bhappens\b", text)):
        return FileKind.SCRIPT
    return next((kind for kind, needed in _TELLING if needed <= keys), FileKind.OTHER)


def refuse_other(document: Document, wanted: FileKind) -> None:
    """Refuse a file of another known kind in one sentence, instead of all its unknown keys.

    Raises:
        LoadError: The file is of another kind.
    """
    kind = kind_of_text(document.text)
    if kind in (wanted, FileKind.OTHER, FileKind.UNREADABLE):
        return
    problems = Problems(document)
    problems.add("kind", (), f"expected a {wanted}, and this is {_with_article(kind)}")
    raise LoadError(problems.all)


def _with_article(kind: FileKind) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def _lists_triggers(text: str) -> bool:
    """Return whether a file that holds a list is a trace script."""
    keys = {key for key in _ENTRY if re.search(rf"""\b{key}["']?[ \t]*:""", text)}
    return "trigger" in keys or len(keys) > 1


def _beginning(path: FilePath) -> str | None:
    """Return the beginning of the file, or None if it cannot be read."""
    try:
        with opened(path) as stream:
            content = stream.read(LARGEST_FILE)
    except (OSError, ValueError):
        return None
    wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    return content.decode("utf-16" if wide else "utf-8-sig", errors="replace")
