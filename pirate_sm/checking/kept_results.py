"""Keeps results of checks in the user's cache folder, each with what was asked of the disk for it.

A result is used again if all that it depends on is as it was: the files of this package, Python,
the installed distributions, the working folder, the inputs that its maker names, and the answers to
all questions that were asked of the disk (`on_disk.py`), which are asked again. What another
package's code does cannot be asked again, and is not kept.

The folder is only for its owner, and nothing in it is trusted more than that: an entry is text with
a digest of itself. One that cannot be used is made again, and where nothing can be written nothing
is kept.
"""

from __future__ import annotations

import json
import os
import re
import stat
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from hashlib import blake2b
from itertools import accumulate
from pathlib import Path
from time import time
from typing import Any, Final, NamedTuple

from pirate_sm.core.on_disk import PART, DiskAnswers, here, is_there, noting

FOLDER_VARIABLE: Final = "PIRATE_SM_CACHE"
"""Names the folder, instead of the user's; empty: nothing is kept."""

LARGEST: Final = 1 << 26
"""What all entries take together, bytes; the oldest are removed. [decided]"""

_AFTER_CLEARING: Final = LARGEST * 3 // 4
"""What is left when the oldest are removed, so that this is rare, bytes. [decided]"""

_COARSEST_S: Final = 2.0
"""The coarsest step of times of files: of FAT. What changed later may look unchanged."""

_BEGAN_S: Final = time()
_PACKAGE: Final = Path(__file__).parents[1]
_DISTRIBUTIONS: Final = (".dist-info", ".egg-info", ".egg-link", ".pth")
_VARIABLES: Final = {"HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME"}
_ENTRY: Final = re.compile(rf"[0-9a-f]{{32}}(\.[0-9a-f]{{8}}{re.escape(PART)})?")


@dataclass
class _Using:
    """The use of the folder by a command.

    Attributes:
        stamp: Of all that is the same for all results of the command.
        waiting: New entries by their keys, until the result that they are a part of is known.
        depth: How many results are being made, one for the other.
    """

    folder: Path
    stamp: str
    waiting: dict[str, bytes] = field(default_factory=dict)
    depth: int = 0


_using: ContextVar[_Using | None] = ContextVar("using", default=None)


@contextmanager
def kept_results() -> Iterator[None]:
    """Return a context in which results are kept and used again."""
    folder, stamp = results_folder(), _stamp()
    using = None
    if folder is not None and stamp is not None and here():
        using = _Using(folder, stamp) if _is_ours(folder) or not is_there(folder) else None
    before = _using.set(using)
    try:
        yield
    finally:
        _using.reset(before)


def kept(what: str, inputs: tuple[Any, ...], make: Callable[[], Any]) -> Any:
    """Return a result from the folder, or from its maker, and keep it.

    Args:
        what: What kind of result it is.
        inputs: All that it depends on besides files, as plain values.
        make: Makes it, as JSON.
    """
    using = _using.get()
    if using is None:
        return make()
    key = _key(using, what, inputs)
    found = _read(using.folder / key)
    if found is not None:
        return found
    using.depth += 1
    try:
        with noting() as asked:
            result = make()
        if asked.whole:
            using.waiting[key] = _written(asked, result)
        return result
    finally:
        using.depth -= 1
        if not using.depth and using.waiting:
            _flush(using)


def again(what: str, inputs: tuple[Any, ...]) -> Any:
    """Return a result from the folder; None without one."""
    using = _using.get()
    return None if using is None else _read(using.folder / _key(using, what, inputs))


def _key(using: _Using, what: str, inputs: tuple[Any, ...]) -> str:
    return _digest(repr((what, inputs, using.stamp, here())).encode())


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
            with (
                suppress(NotADirectoryError, FileNotFoundError),
                os.scandir(place or ".") as inside,
            ):
                named = [each for each in inside if each.name.endswith(_DISTRIBUTIONS)]
                found += sorted((each.path, each.stat().st_mtime_ns) for each in named)
    except OSError:
        return None
    latest_s = max(each.changed_ns for each in found if isinstance(each, _File)) / 1e9
    return None if latest_s > _BEGAN_S - _COARSEST_S else _digest(repr(found).encode())


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


def _read(path: Path) -> Any:
    """Return the result in an entry; None without one whose questions have the same answers."""
    try:
        with path.open("rb") as file:
            digest, content = file.readline().strip(), file.read()
        if digest != _digest(content).encode():
            return None
        data = json.loads(content)
        answers = {(name, at): answer for name, at, answer in data["asked"]}
    except (OSError, ValueError, KeyError, TypeError):
        return None
    asked = DiskAnswers(answers)
    if not asked.holds():
        return None
    asked.repeat()
    with suppress(OSError):
        os.utime(path)  # the oldest are removed first
    return data["result"]


def _written(asked: DiskAnswers, result: Any) -> bytes:
    answers = [[*question, answer] for question, answer in asked.answers.items()]
    content = json.dumps({"asked": answers, "result": result}).encode()
    return _digest(content).encode() + b"\n" + content


def _flush(using: _Using) -> None:
    """Write the new entries, each atomically, unless the package has changed meanwhile."""
    waiting, using.waiting = using.waiting, {}
    if _stamp() != using.stamp or not _made(using.folder):
        return
    with suppress(OSError):
        for key, content in waiting.items():
            part = using.folder / f"{key}.{os.urandom(4).hex()}{PART}"
            try:
                part.write_bytes(content)
                part.replace(using.folder / key)
            finally:
                part.unlink(missing_ok=True)
        _bound(using.folder)


def _digest(content: bytes) -> str:
    return blake2b(content, digest_size=16).hexdigest()


# --- the folder -----------------------------------------------------------------------------------


def results_folder() -> Path | None:
    """Return the folder of the entries, which may not exist; None if nothing is to be kept."""
    given = os.environ.get(FOLDER_VARIABLE)
    if given is None:
        from platformdirs import user_cache_path

        return user_cache_path("pirate_sm", appauthor=False) / "checks"
    return Path(given).absolute() / "checks" if given else None


def _made(folder: Path) -> bool:
    """Return whether the folder is there, after making it, and only its owner can use it."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
    except OSError:
        return False
    return _is_ours(folder)


def _is_ours(folder: Path) -> bool:
    """Return whether a folder is ours, and closed to others."""
    try:
        seen = os.lstat(folder)
    except OSError:
        return False
    closed = not stat.S_IMODE(seen.st_mode) & 0o077
    return stat.S_ISDIR(seen.st_mode) and seen.st_uid == os.geteuid() and closed


class KeptEntry(NamedTuple):
    """An entry in the folder."""

    used_s: float
    size: int
    path: str


def entries(folder: Path) -> list[KeptEntry]:
    """Return the entries, those first that have not been used for the longest time."""
    with suppress(OSError), os.scandir(folder) as inside:
        ours = [each for each in inside if _ENTRY.fullmatch(each.name)]
        seen = [(each.stat(follow_symlinks=False), each.path) for each in ours]
        return sorted(KeptEntry(it.st_mtime, it.st_size, path) for it, path in seen)
    return []


def remove(unwanted: Iterable[KeptEntry]) -> None:
    """Remove entries.

    Raises:
        OSError: One cannot be removed.
    """
    for each in unwanted:
        Path(each.path).unlink(missing_ok=True)


def _bound(folder: Path) -> None:
    """Remove the oldest entries if all together are too large."""
    found = entries(folder)
    sizes = [*accumulate(each.size for each in reversed(found))]
    if sizes and sizes[-1] > LARGEST:
        remove(found[: sum(size > _AFTER_CLEARING for size in sizes)])
