"""The shipped names and the files that a shell offers for an option or an argument.

Options name these functions, as those of :mod:`candidates`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator
from itertools import islice
from pathlib import Path

import typer

from pirate_sm.cli.completion.reading import RECORDING, Candidate, about_file, line, read
from pirate_sm.core.files import PROFILE_FILE, library
from pirate_sm.core.on_disk import is_file, is_folder

MOST_FILES = 1000
"""The most files of a folder that are read."""

MOST_RUNS = 20
"""The most recordings that are offered from the folder for recordings; the newest ones."""


def _of(
    shipped: Callable[[], Iterable[Path]], fits: Callable[[Path], bool]
) -> Callable[[typer.Context, str], Iterator[Candidate]]:
    """Return a function that yields shipped names, and the files that fit."""

    def found(context: typer.Context, typed: str) -> Iterator[Candidate]:
        yield from _shipped(shipped(), typed)
        yield from _files(typed, fits)

    return found


missions = _of(library.missions, lambda path: _is(path, {"mission"}))
missions_or_recordings = _of(
    library.missions, lambda path: path.suffix == RECORDING or _is(path, {"mission"})
)
campaigns = _of(library.missions, lambda path: _is(path, {"campaign", "mission"}))
pipes = _of(library.pipes, lambda path: _is(path, {"pipe"}))
cameras = _of(library.cameras, lambda path: _is(path, {"camera"}))
panels = _of(library.panels, lambda path: _is(path, {"panel"}))
scripts = _of(tuple, lambda path: _is(path, {"trace script"}))
twins = _of(tuple, lambda path: _is(path, {"twin"}))
charts_in_scxml = _of(tuple, lambda path: path.suffix in {".scxml", ".xml"})
checkable = _of(tuple, lambda path: path.suffix in library.SUFFIXES)
files = _of(tuple, lambda path: True)
folders = _of(tuple, lambda path: False)


def robots(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the shipped robots, and folders."""
    for robot in library.robots():
        if robot.name.startswith(typed):
            yield robot.name, about_file(robot / PROFILE_FILE)
    for folder, about in folders(context, typed):
        profile = Path(folder).expanduser() / PROFILE_FILE
        yield (folder.rstrip("/"), about_file(profile)) if is_file(profile) else (folder, about)


def scenes(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the scenes of the gallery, and files."""
    for path in library.scenes():
        if path.stem.startswith(typed):
            yield path.stem, line(read(path).get("title"))
    yield from _files(typed, lambda path: "scene" in read(path))


def drawable(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield missions, robots and pipes, and files of them and of charts."""
    yield from _shipped([*library.missions(), *library.pipes()], typed)
    yield from robots(context, typed)
    yield from _files(typed, lambda path: _is(path, {"mission", "pipe", "robot", "chart"}))


def recordings(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield recordings of the working folder, and the newest of the folder for recordings."""
    yield from _files(typed, lambda path: path.suffix == RECORDING)
    from pirate_sm.cli.settings import values

    runs = values()["runs"]
    if not typed and runs.value and not runs.refused:
        names = (each.name for each in _entries(Path(runs.value)) if each.name.endswith(RECORDING))
        for name in sorted(names, reverse=True)[:MOST_RUNS]:  # they begin with the time
            yield f"{runs.value}/{name}", ""


def recordings_or_tables(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield recordings, and tables in CSV files."""
    yield from recordings(context, typed)
    yield from _files(typed, lambda path: path.suffix == ".csv")


def _shipped(paths: Iterable[Path], typed: str) -> Iterator[Candidate]:
    for path in paths:
        if path.stem.startswith(typed):
            yield path.stem, about_file(path)


def _files(typed: str, fits: Callable[[Path], bool]) -> Iterator[Candidate]:
    """Yield files and folders whose path begins so; a ``~`` stays as it is."""
    folder, slash, name = typed.rpartition("/")
    inside = Path(f"{folder}{slash}" or ".").expanduser()
    for each in _entries(inside):
        if not each.name.startswith(name) or (each.name[0] == "." and not name):
            continue
        path = inside / each.name
        if is_folder(each):
            yield f"{folder}{slash}{each.name}/", ""
        elif fits(path):
            yield f"{folder}{slash}{each.name}", about_file(path)


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    """Return what is in a folder, sorted by name; nothing if it cannot be read."""
    try:
        with os.scandir(folder) as found:
            return sorted(islice(found, MOST_FILES), key=lambda each: each.name)
    except OSError:
        return []


def _is(path: Path, kinds: Collection[str]) -> bool:
    from pirate_sm.core.documents import kind_of

    return path.suffix in library.SUFFIXES and kind_of(path) in kinds
