"""Follow references from one file to another, inside the project where that is wanted.

A mission may come from a stranger, and messages quote what they are about: into the log of a build
server, say. So files are quoted only if they are ours, and who checks can keep references inside.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path as FilePath

from pirate_sm.errors import PirateError, UsageError
from pirate_sm.loading import library
from pirate_sm.loading.problems import LoadError, Path, Problems
from pirate_sm.loading.yaml.document import LARGEST_FILE

MISSION = ("mission", "robot", "start", "phases", "ends")
PIPE = ("pipe", "diameter", "segments")
"""Keys of which a file of ours has some, however broken it is."""

LEAST_KEYS = 2
"""How many there are; one may stand anywhere."""

ROOT_MARKS = (".git", "sequences", "hardware_profiles")
"""What the root of a project has."""

_kept_inside: ContextVar[bool] = ContextVar("kept_inside", default=False)


class OutsideError(UsageError):
    """Raised for a reference that leaves the project, where that is not wanted."""


def code_of(error: PirateError, usual: str) -> str:
    """Return the code for a reference that fails: ``usual``, unless it leaves the project."""
    return "reference.outside" if isinstance(error, OutsideError) else usual


@contextmanager
def kept_inside(*, wanted: bool) -> Iterator[None]:
    """Refuse references that leave the project, inside the context and if that is wanted."""
    before = _kept_inside.set(wanted)
    try:
        yield
    finally:
        _kept_inside.reset(before)


def followed(file: FilePath, folder: FilePath) -> FilePath:
    """Return the file that a reference leads to.

    Args:
        file: Where it leads.
        folder: Of the file in which it stands.

    Raises:
        OutsideError: It leaves the project, and that is not wanted.
    """
    if _kept_inside.get() and not any(file.resolve().is_relative_to(r) for r in _roots(folder)):
        raise OutsideError("this leads out of the project's folder")
    return file


def _roots(folder: FilePath) -> Iterator[FilePath]:
    """Yield the folders in which a reference from this folder may lead."""
    here = folder.resolve()
    yield here
    yield from (library.shipped() / name for name in ("sequences", "hardware_profiles"))
    if here.is_relative_to(FilePath.cwd()):
        yield FilePath.cwd()
    for above in (here, *here.parents):
        if any((above / mark).exists() for mark in ROOT_MARKS):
            yield above
            return


def tell(
    error: LoadError, file: FilePath, keys: tuple[str, ...], at: Path, problems: Problems
) -> None:
    """Report what is wrong with a file; of one of another kind only that it is the wrong file.

    Args:
        error: What reading the file has raised.
        file: The file.
        keys: Some of these it has, if it is of the kind that is meant.
        at: Where it is named, in the file that the problems are about.
        problems: Are added to.
    """
    if _has(file, keys):
        for problem in error.problems:
            problems.put(problem)
        return
    code = "mission.pipe" if keys is PIPE else "mission.call"
    problems.add(code, at, f"this leads to a file that is no {keys[0]}")


def _has(file: FilePath, keys: tuple[str, ...]) -> bool:
    """Return whether some keys begin a line or stand in braces, or the file is unreadable."""
    with suppress(OSError, ValueError):
        with file.open("rb") as stream:
            text = stream.read(LARGEST_FILE).decode("utf-8-sig", errors="replace")
        names = "|".join(keys)
        found = re.findall(rf"""(?:^|[{{,\r])\s*["']?({names})["']?\s*:""", text, re.MULTILINE)
        return not text.strip() or len(set(found)) >= LEAST_KEYS
    return True
