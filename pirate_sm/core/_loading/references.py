"""Follow references from one file to another, also to one that it extends, and tell kinds of files.

A mission may come from an untrusted source, and messages quote the files that they concern, for
instance in the log of a build server. Therefore only files in our formats are quoted, and a check
can restrict references to the project. The kind of a file is known from its text, even if the file
is too broken to be read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from enum import StrEnum
from pathlib import Path as FilePath

from pirate_sm.core import library
from pirate_sm.core._loading.problems import LoadError, Path, Problems
from pirate_sm.core._loading.yaml.document import LARGEST_FILE, Document, read_document
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.library import PROFILE_FILE
from pirate_sm.core.on_disk import is_there, opened, resolved

MISSION = ("mission", "robot", "start", "phases", "ends")
PIPE = ("pipe", "diameter", "segments")
"""Keys of our formats; even a broken file has some of them."""

LEAST_KEYS = 2
"""Number of these keys for recognition, because a single one may occur in any file."""

ROOT_MARKS = (".git", "sequences", "hardware_profiles")
"""Names that mark the root of a project."""

_kept_inside: ContextVar[bool] = ContextVar("kept_inside", default=False)


class OutsideError(UsageError):
    """Raised for a reference that leaves the project while that is not allowed."""


def code_of(error: PirateError, usual: str) -> str:
    """Return the fault code of a failed reference: ``usual``, unless it leaves the project."""
    return "reference.outside" if isinstance(error, OutsideError) else usual


@contextmanager
def kept_inside(*, wanted: bool) -> Iterator[None]:
    """Return a context that refuses references out of the project if ``wanted``."""
    before = _kept_inside.set(wanted)
    try:
        yield
    finally:
        _kept_inside.reset(before)


def keeps_inside() -> bool:
    """Return whether references out of the project are refused."""
    return _kept_inside.get()


def followed(file: FilePath, folder: FilePath) -> FilePath:
    """Return the file of a reference, checked against the project's folder.

    Args:
        file: The path in the reference.
        folder: The folder of the file with the reference.

    Raises:
        OutsideError: It leaves the project, and that is not allowed.
    """
    if _kept_inside.get() and not any(resolved(file).is_relative_to(r) for r in _roots(folder)):
        raise OutsideError("this leads out of the project's folder")
    return file


def _roots(folder: FilePath) -> Iterator[FilePath]:
    """Yield the folders that a reference from this folder may enter."""
    here = resolved(folder)
    yield here
    yield from (library.shipped() / name for name in ("sequences", "hardware_profiles"))
    if here.is_relative_to(FilePath.cwd()):
        yield FilePath.cwd()
    if (root := project_of(here)) is not None:
        yield root


def project_of(folder: FilePath) -> FilePath | None:
    """Return the nearest folder of a project that a folder is in; None without one."""
    marked = (
        each for each in (folder, *folder.parents) for mark in ROOT_MARKS if is_there(each / mark)
    )
    return next(marked, None)


def tell(
    error: LoadError, file: FilePath, keys: tuple[str, ...], at: Path, problems: Problems
) -> None:
    """Report the faults of a referenced file, or only that it is of another kind.

    Args:
        error: The error raised by reading the file.
        file: The file.
        keys: Keys of which a file of the right kind has some.
        at: Path of the reference in the file that is being checked.
        problems: Collects the faults.
    """
    if _has(file, keys):
        problems.take(error)
        return
    code = "mission.pipe" if keys is PIPE else "mission.call"
    problems.add(code, at, f"this leads to a file that is no {keys[0]}")


def _has(file: FilePath, keys: tuple[str, ...]) -> bool:
    """Return whether the file has some of the keys, or cannot be read."""
    with suppress(OSError, ValueError):
        with opened(file) as stream:
            text = stream.read(LARGEST_FILE).decode("utf-8-sig", errors="replace")
        names = "|".join(keys)
        found = re.findall(rf"""(?:^|[{{,\r])\s*["']?({names})["']?\s*:""", text, re.MULTILINE)
        return not text.strip() or len(set(found)) >= LEAST_KEYS
    return True


EXTENDS = "extends"
"""The key that names the file below, relative to the folder of the file above."""


def read_extended(path: FilePath) -> Document:
    """Return the document of a file, laid over the one that it extends, if it extends one.

    Mappings are merged; a list, a text or a number replaces what is below.

    Raises:
        LoadError: A file cannot be read, or the files extend each other; holds all faults.
    """
    return _read_above(path, ())


def extended_folders(path: FilePath) -> tuple[FilePath, ...]:
    """Return the folders of a sound file and of all files that it extends, itself first."""
    data = read_document(path).data
    given = data.get(EXTENDS) if isinstance(data, dict) else None
    below = extended_folders(path.parent / str(given)) if given else ()
    return resolved(path.parent), *below


def _read_above(path: FilePath, above: tuple[FilePath, ...]) -> Document:
    document = read_document(path)
    given = document.data.get(EXTENDS) if isinstance(document.data, dict) else None
    if given is None:
        return document
    problems = Problems(document)
    if not isinstance(given, str) or not given:
        problems.add(
            "robot.extends", (EXTENDS,), "expected the path of the file that this one extends"
        )
        problems.raise_errors()
    below, files = path.parent / str(given), (*above, resolved(path))
    if resolved(below) in files:
        problems.add("robot.extends", (EXTENDS,), "these files extend each other")
        problems.raise_errors()
    try:
        return document.extending(_read_above(followed(below, path.parent), files), EXTENDS)
    except UsageError as error:
        problems.add(code_of(error, "robot.extends"), (EXTENDS,), str(error))
    except LoadError as error:
        problems.take(error, "robot.extends", (EXTENDS,))
    problems.raise_errors()
    raise AssertionError("raise_errors raises here")


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

_EXTENDING = re.compile(r"^extends[ \t]*:", re.MULTILINE)

_CONTENT = re.compile(r"^([ ]*)([^\s#%].*)$", re.MULTILINE)
_WORD = r"""["']?([A-Za-z_][A-Za-z0-9_]*)["']?[ \t]*:(?=\s|$)"""
_IN_BRACES = re.compile(r"""[\s{,]["']?([A-Za-z_][A-Za-z0-9_]*)["']?[ \t]*:""")


def kind_of(path: FilePath) -> FileKind:
    """Return the kind of the file."""
    text = _beginning(path)
    kind = FileKind.UNREADABLE if text is None else kind_of_text(text)
    extends = kind is FileKind.OTHER and path.name == PROFILE_FILE and _EXTENDING.search(text or "")
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
