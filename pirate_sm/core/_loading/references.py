"""Follow references from one file to another, optionally only inside the project.

A mission may come from an untrusted source, and messages quote the files that they concern, for
instance in the log of a build server. Therefore only files in our formats are quoted, and a check
can restrict references to the project.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path as FilePath

from pirate_sm.core._loading import library
from pirate_sm.core._loading.problems import LoadError, Path, Problems
from pirate_sm.core._loading.yaml.document import LARGEST_FILE
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.on_disk import is_there, opened

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


def followed(file: FilePath, folder: FilePath) -> FilePath:
    """Return the file of a reference, checked against the project's folder.

    Args:
        file: The path in the reference.
        folder: The folder of the file with the reference.

    Raises:
        OutsideError: It leaves the project, and that is not allowed.
    """
    if _kept_inside.get() and not any(file.resolve().is_relative_to(r) for r in _roots(folder)):
        raise OutsideError("this leads out of the project's folder")
    return file


def _roots(folder: FilePath) -> Iterator[FilePath]:
    """Yield the folders that a reference from this folder may enter."""
    here = folder.resolve()
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
