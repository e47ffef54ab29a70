"""Keeps results of checks in the user's cache folder, each with what was asked of the disk for it.

A result is used again if all that it depends on is as it was: the files of this package, Python,
the installed distributions, the working folder, the inputs that its maker names, and the answers to
all questions that were asked of the disk (`on_disk.py`), which are asked again. What another
package's code does cannot be asked again, and is not kept.

An entry (`kept_entries.py`) that cannot be used is made again.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from time import time
from typing import Any, Final, NamedTuple, TypeVar

from pirate_sm.core.kept_entries import Entries, digest, results
from pirate_sm.core.on_disk import DiskAnswers, here, noting

R = TypeVar("R")

_COARSEST_S: Final = 2.0
"""The coarsest step of times of files: of FAT. What changed later may look unchanged."""

_BEGAN_S: Final = time()
_PACKAGE: Final = Path(__file__).parents[1]
_DISTRIBUTIONS: Final = (".dist-info", ".egg-info", ".egg-link", ".pth")
_MOST_IN_MEMORY: Final = 1000
"""More entries are not kept in memory. [decided] A file has one, which its next text replaces."""
_VARIABLES: Final = {"HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME"}


@dataclass
class _Using:
    """The use of the folder by a command.

    Attributes:
        stamp: Of all that is the same for all results of the command; empty: it cannot change.
        waiting: New entries by their keys, until the result that they are a part of is known.
        depth: How many results are being made, one for the other.
    """

    entries: Entries | KeptInMemory
    stamp: str
    waiting: dict[str, Any] = field(default_factory=dict)
    depth: int = 0


_using: ContextVar[_Using | None] = ContextVar("using", default=None)


@contextmanager
def kept_results() -> Iterator[None]:
    """Return a context in which results are kept and used again; inside of one it is that one."""
    if _using.get() is not None:
        yield
        return
    entries, stamp = results(), _stamp()
    using = None
    if entries is not None and stamp is not None and here():
        using = _Using(entries, stamp)
    with _use(using):
        yield


class KeptInMemory(dict[str, Any]):
    """Entries that a process keeps for itself: its package and all that is installed stay."""

    def read(self, key: str) -> Any:
        """Return what an entry holds; None without one."""
        return self.get(key)

    def write(self, new: Mapping[str, Any]) -> None:
        """Write entries; the first that were written make room."""
        self.update(new)
        for key in [*self][:-_MOST_IN_MEMORY]:
            del self[key]

    def used(self) -> AbstractContextManager[None]:
        """Return a context in which results are kept here and used again."""
        return _use(_Using(self, ""))


@contextmanager
def _use(using: _Using | None) -> Iterator[None]:
    before = _using.set(using)
    try:
        yield
    finally:
        _using.reset(before)


def kept(
    what: str, inputs: tuple[Any, ...], make: Callable[[], Any], read: Callable[[Any], R]
) -> R:
    """Return a result from the folder, or from its maker, and keep it.

    Args:
        what: What kind of result it is.
        inputs: All that it depends on besides files, as plain values.
        make: Makes it, as JSON.
        read: Reads it from JSON; raises for what is not such a result.
    """
    using = _using.get()
    if using is None:
        return read(make())
    key = _key(using, what, inputs)
    found = _read(using, key, read)
    if found is not None:
        return found
    using.depth += 1
    try:
        with noting() as asked:
            result = make()
        if asked.whole:
            using.waiting[key] = _written(asked, result)
        return read(result)
    finally:
        using.depth -= 1
        if not using.depth and using.waiting:
            _flush(using)


def again(what: str, inputs: tuple[Any, ...], read: Callable[[Any], R]) -> R | None:
    """Return a result from the folder; None without one."""
    using = _using.get()
    return None if using is None else _read(using, _key(using, what, inputs), read)


def take_waiting() -> dict[str, Any]:
    """Return the new entries, which another process writes."""
    using, waiting = _using.get(), {}
    if using is not None:
        waiting, using.waiting = using.waiting, waiting
    return waiting


def add_waiting(entries: Mapping[str, Any]) -> None:
    """Add the new entries of another process to those that wait."""
    using = _using.get()
    if using is not None:
        using.waiting.update(entries)


def _key(using: _Using, what: str, inputs: tuple[Any, ...]) -> str:
    return digest(repr((what, inputs, using.stamp, here())).encode())


# --- what is the same for all results -------------------------------------------------------------


def _stamp() -> str | None:
    """Return a digest of the package and of what it runs on; None if it is changing.

    Files of the package count by their size and times, of which no program can set that of the
    last change. If one may have changed since this process began, some of what it runs is older.
    """
    found: list[Any] = [sys.version, sys.flags, os.uname().machine]
    found += sorted(each for each in os.environ.items() if each[0] in _VARIABLES)
    try:
        found += _files_of(str(_PACKAGE))
        for place in sys.path:
            found += _installed(place or ".")
    except OSError:
        return None
    latest_s = max(each.changed_ns for each in found if isinstance(each, _File)) / 1e9
    return None if latest_s > _BEGAN_S - _COARSEST_S else digest(repr(found).encode())


def _installed(place: str) -> Iterator[Any]:
    """Yield the names of what is installed in a place, and when each was changed."""
    named = []
    with suppress(NotADirectoryError, FileNotFoundError), os.scandir(place) as inside:
        named = sorted(each.path for each in inside if each.name.endswith(_DISTRIBUTIONS))
    for each in named:
        for path in (each, f"{each}/entry_points.txt"):
            yield path
            with suppress(OSError):  # it is absent, or a dangling link
                seen = os.stat(path)  # noqa: PTH116 - there are hundreds
                yield seen.st_size, seen.st_mtime_ns, seen.st_ctime_ns


class _File(NamedTuple):
    path: str
    size: int
    modified_ns: int
    changed_ns: int


def _files_of(folder: str) -> Iterator[_File]:
    """Yield the files in a folder of the package that can change what it does."""
    with os.scandir(folder) as inside:
        entries = sorted(inside, key=lambda each: each.name)
    for each in entries:
        if each.is_dir():
            yield from _files_of(each.path) if each.name != "__pycache__" else ()
        elif each.name.endswith((".py", ".yaml")):
            seen = each.stat()
            yield _File(each.path, seen.st_size, seen.st_mtime_ns, seen.st_ctime_ns)


# --- entries --------------------------------------------------------------------------------------


def _read(using: _Using, key: str, read: Callable[[Any], R]) -> R | None:
    """Return the result in an entry; None without one whose questions have the same answers."""
    try:
        data = using.entries.read(key)
        answers = {(str(name), str(at)): answer for name, at, answer in data["asked"]}
        asked = DiskAnswers(answers)
        result = read(data["result"]) if asked.holds() else None
    except (ValueError, LookupError, TypeError, AttributeError):
        return None  # there is none, or it is malformed
    if result is not None:
        asked.repeat()
    return result


def _written(asked: DiskAnswers, result: Any) -> dict[str, Any]:
    answers = [[*question, answer] for question, answer in asked.answers.items()]
    return {"asked": answers, "result": result}


def _flush(using: _Using) -> None:
    """Write the new entries, unless the package has changed meanwhile."""
    waiting, using.waiting = using.waiting, {}
    if not using.stamp or _stamp() == using.stamp:
        using.entries.write(waiting)
