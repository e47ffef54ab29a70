"""Find the files of a project that are to be checked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.core import library
from pirate_sm.core.documents import FileKind, Place, kind_of
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import PROFILE_FILE, shown
from pirate_sm.core.loading import project_of
from pirate_sm.core.on_disk import is_file, is_folder, is_there, listed, resolved
from pirate_sm.core.spelling import nearest

ROBOTS, MISSIONS, CAMERAS, PANELS = "hardware_profiles", "sequences", "cameras", "panels"
CAMPAIGNS = "campaigns"
"""The folders of a project's robots, missions, cameras, control panels and campaigns."""

MOST_FILES = 10_000
DEEPEST_FOLDER = 32
_LONGEST_NAME = 200


@dataclass(frozen=True)
class CheckTarget:
    """A file to check.

    Attributes:
        path: The file; for a robot its profile.
        named: Whether it was named explicitly; otherwise it was found in a folder.
    """

    kind: FileKind
    path: Path
    named: bool


@dataclass(frozen=True)
class FoundFiles:
    """The files of a check, and findings about the searched folders.

    Attributes:
        where: The searched files and folders, as in messages.
    """

    targets: tuple[CheckTarget, ...]
    findings: tuple[Finding, ...]
    where: tuple[str, ...] = ()


def find_targets(paths: Iterable[str]) -> FoundFiles:
    """Return the distinct files to check, robots first because missions depend on them.

    Args:
        paths: Files, folders or names of shipped files; empty for the working directory.

    Raises:
        UsageError: A path does not exist.
    """
    given = list(paths)
    found: dict[Path, CheckTarget] = {}
    findings: list[Finding] = []
    searched = [_existing(each) for each in given] if given else _project(findings)
    for path in searched:
        for target in _targets(path, findings, named=bool(given)):
            found.setdefault(_real(target.path), target)
    if not (given or found or findings):
        findings.append(_nothing(Path()))
    order = list(FileKind)
    targets = sorted(found.values(), key=lambda each: (order.index(each.kind), each.path))
    return FoundFiles(tuple(targets), tuple(findings), tuple(map(shown, searched)))


def _project(findings: list[Finding]) -> list[Path]:
    """Return the files and folders of the project in the working directory.

    With a folder for missions, these are that folder, those for robots, cameras, panels and
    campaigns, and the files next to them. Without one, it is the whole directory, because missions
    may be anywhere.
    """
    if not is_folder(Path(MISSIONS)):
        return [Path()]
    folders = (ROBOTS, MISSIONS, CAMERAS, PANELS, CAMPAIGNS)
    own = [Path(folder) for folder in folders if is_folder(Path(folder))]
    beside, _ = _listing(Path(), findings)
    return [*own, *(file for file in beside if kind_of(file) is not FileKind.OTHER)]


def robots_around(path: Path) -> set[Path]:
    """Return the folders of the robots next to a file, and in its project.

    The project is the nearest folder with the marks of one, else the working directory.
    """
    here = resolved(path).parent
    folders = {*_folders(here, 2), *_folders(project_of(here) or Path.cwd(), 2)}
    return {folder for folder in folders if is_file(folder / PROFILE_FILE)}


def _folders(folder: Path, deep: int) -> Iterator[Path]:
    """Yield a folder and those in it, to a depth, without those that cannot be searched."""
    yield folder
    with suppress(OSError):
        for each in listed(folder) if deep else ():
            if each.is_folder:
                yield from _folders(folder / each.name, deep - 1)


def _existing(name: str) -> Path:
    """Return the file or folder at this path, or the shipped file of this name.

    Raises:
        UsageError: Neither exists.
    """
    library.refuse_recording(name, "YAML file")
    if is_there(name):
        return Path(name)
    known = {path.stem: path for path in (*library.robots(), *library.pipes())}
    known |= {path.stem: path for path in (*library.cameras(), *library.panels())}
    known |= {path.stem: path for path in library.missions()}
    if name in known:
        return known[name]
    close = nearest(name, known)
    shipped = "" if library.is_path(name) else ", ".join(p.stem for p in library.missions())
    others = f"; shipped missions are {shipped}" if shipped else ""
    hint = f"; did you mean '{close}'?" if close else others
    visible = name.replace("\0", "\\0")[:_LONGEST_NAME]
    raise UsageError(f"there is no file or folder '{visible}'{hint}")


def _targets(path: Path, findings: list[Finding], *, named: bool) -> Iterator[CheckTarget]:
    if not is_folder(path):
        kind = kind_of(path)
        beside = path.parent / PROFILE_FILE
        if kind is FileKind.CHART and kind_of(beside) is FileKind.ROBOT:
            yield CheckTarget(FileKind.ROBOT, beside, named)  # a chart is checked with its robot
        yield CheckTarget(kind, path, named)
        return
    before, empty = len(findings), True
    for file in _files(path, findings):
        kind = kind_of(file)
        if kind is not FileKind.OTHER:
            yield CheckTarget(kind, file, named=False)
            empty = False
    if empty and named and len(findings) == before:
        findings.append(_nothing(path))


def _files(folder: Path, findings: list[Finding]) -> Iterator[Path]:
    """Yield all YAML files below a folder, without hidden files and links to folders."""
    waiting, count = [(folder, 0)], 0
    while waiting:
        current, depth = waiting.pop()
        if depth > DEEPEST_FOLDER:
            message = f"folders are nested more than {DEEPEST_FOLDER} levels"
            findings.append(_finding("check.folder", current, message))
            continue
        files, inner = _listing(current, findings)
        waiting += [(each, depth + 1) for each in reversed(inner)]
        for file in files:
            count += 1
            if count > MOST_FILES:
                message = f"there are more than {MOST_FILES} YAML files in here"
                fix = "check its folders one by one"
                findings.append(replace(_finding("check.folder", folder, message), fix=fix))
                return
            yield file


def _listing(folder: Path, findings: list[Finding]) -> tuple[list[Path], list[Path]]:
    """Return the YAML files and the folders in a folder, ordered by name."""
    try:
        seen = [each for each in listed(folder) if not each.name.startswith(".")]
    except OSError as error:
        message = f"cannot be searched: {error.strerror}"
        findings.append(_finding("check.folder", folder, message))
        return [], []
    files = [folder / each.name for each in seen if not each.is_folder]
    return files, [folder / each.name for each in seen if each.is_folder and not each.is_link]


def _real(path: Path) -> Path:
    try:
        return resolved(path)
    except (OSError, RuntimeError):
        return path.absolute()


def _nothing(folder: Path) -> Finding:
    return _finding(
        "check.nothing", folder, "there is no robot, mission, pipe or camera in this folder"
    )


def _finding(code: str, path: Path, message: str) -> Finding:
    return Finding(code, Severity.ERROR, Place(shown(path)), message)
