"""Asks what is at a path, and remembers on request what was asked, to ask it again.

The questions of ``pathlib`` raise for some paths and deny that there is anything at others. Here
what is in a folder that may not be entered is there, and neither a file nor a folder: whoever opens
it says why it cannot be read or written. Nothing is at a path that no file can have, such as one
that is too long.

Loading and checking ask the disk only here, so that a result can be kept with all questions that
it depends on, and used again as long as they have the same answers.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import wraps
from hashlib import blake2b
from io import BufferedReader, BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple, ParamSpec, TypeVar, cast

P = ParamSpec("P")
R = TypeVar("R")

YAML = (".yaml", ".yml")
"""Endings of our files."""

PART = ".part"
"""Ending of a file that is not whole yet."""

_NOTHING = {errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG}
"""Errors of a path at which nothing is."""

_WITHOUT_WAITING = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
"""Flags that open a named pipe although nobody writes to it; no system has them all."""


# --- what was asked -------------------------------------------------------------------------------


_LARGEST_NOTED: Final = 1 << 26
"""What is read of a larger file is not noted, bytes. [decided]"""


@dataclass
class DiskAnswers:
    """Questions about paths, each with a text that tells its answer from any other.

    Attributes:
        answers: The answers by the names of the questions and their paths.
        whole: Whether these are all questions, and none had two answers.
    """

    answers: dict[tuple[str, str], str] = field(default_factory=dict)
    whole: bool = True

    def note(self, name: str, path: str, answer: str) -> None:
        """Add a question with its answer."""
        self.whole &= self.answers.setdefault((name, path), answer) == answer

    @property
    def contents(self) -> list[str]:
        """Return the paths of the files that were read, in this order."""
        return [path for name, path in self.answers if name == _content.__name__]

    def holds(self) -> bool:
        """Return whether all questions have the same answers now."""
        return self.whole and all(
            _told(_QUESTIONS[name], path)[1] == answer
            for (name, path), answer in self.answers.items()
        )

    def repeat(self) -> None:
        """Tell those who want to know that these questions were asked."""
        for each in _listening.get():
            each.whole &= self.whole
            for (name, path), answer in self.answers.items():
                each.note(name, path, answer)


_listening: ContextVar[tuple[DiskAnswers, ...]] = ContextVar("listening", default=())
_QUESTIONS: Final[dict[str, Callable[[Path | str], Any]]] = {}


@contextmanager
def noting() -> Iterator[DiskAnswers]:
    """Return a context that notes all questions."""
    asked = DiskAnswers()
    before = _listening.set((*_listening.get(), asked))
    try:
        yield asked
    finally:
        _listening.reset(before)


def asks_elsewhere() -> None:
    """Say that a result depends on what cannot be asked here again."""
    for each in _listening.get():
        each.whole = False


def remembered(most: int) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let a function keep its last results, as long as the disk still answers the same.

    Args:
        most: How many are kept.
    """

    def remembering(make: Callable[P, R]) -> Callable[P, R]:
        kept: dict[Hashable, tuple[R, DiskAnswers]] = {}

        @wraps(make)
        def found(*arguments: P.args, **named: P.kwargs) -> R:
            key = (here(), *arguments, *named.items())
            known = kept.get(key)
            if known is not None and known[1].holds():
                known[1].repeat()
                return known[0]
            with noting() as asked:
                result = make(*arguments, **named)
            kept.pop(key, None)
            kept[key] = result, asked
            if len(kept) > most:
                kept.pop(next(iter(kept)), None)  # another thread may have removed it
            return result

        return found

    return remembering


def _question(ask: Callable[[Path | str], R]) -> Callable[[Path | str], R]:
    """Let a question about a path be noted."""
    _QUESTIONS[ask.__name__] = ask

    @wraps(ask)
    def asked(path: Path | str) -> R:
        listening = _listening.get()
        if not listening:
            return ask(path)
        result, answer = _told(ask, path)
        for each in listening:
            each.note(ask.__name__, os.fspath(path), answer)
        if isinstance(result, Exception):
            raise result
        return cast(R, result)

    return asked


def _told(ask: Callable[[Path | str], Any], path: Path | str) -> tuple[Any, str]:
    """Return the answer to a question, or the error that it raises, and a text of it."""
    try:
        result = ask(path)
    except (OSError, RuntimeError, ValueError) as error:
        return error, repr(error)
    if isinstance(result, bytes):
        return result, blake2b(result, digest_size=16).hexdigest()
    return result, repr(result)


def here() -> str:
    """Return the working folder, from which files have their names; empty without one."""
    try:
        return os.getcwd()  # noqa: PTH109 - it is called often
    except OSError:
        return ""


class Listed(NamedTuple):
    """A folder, a link to one, or a YAML file in a folder."""

    name: str
    is_folder: bool
    is_link: bool


# --- what an editor has not saved -----------------------------------------------------------------


_unsaved: ContextVar[Mapping[str, bytes]] = ContextVar("unsaved", default=MappingProxyType({}))


@contextmanager
def unsaved(files: Mapping[str, bytes]) -> Iterator[None]:
    """Return a context in which files hold what is not saved yet.

    Args:
        files: The contents by the paths of the files, with all links followed; a file need not
            exist.
    """
    before = _unsaved.set(files)
    try:
        yield
    finally:
        _unsaved.reset(before)


def _unsaved_at(path: Path | str) -> bytes | None:
    files = _unsaved.get()
    return files.get(os.path.realpath(path)) if files else None


# --- questions ------------------------------------------------------------------------------------


@_question
def is_there(path: Path | str) -> bool:
    """Return whether something is at this path, also a broken link, or it cannot be found out."""
    try:
        there = os.path.lexists(path) or bool(why_hidden(path))
        return there or _unsaved_at(path) is not None
    except ValueError:
        return False


@_question
def is_file(path: Path | str) -> bool:
    """Return whether a file is known to be at this path."""
    try:
        return Path(path).is_file() or _unsaved_at(path) is not None
    except (OSError, ValueError):
        return False


@_question
def is_folder(path: Path | str) -> bool:
    """Return whether a folder is known to be at this path."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


@_question
def resolved(path: Path | str) -> Path:
    """Return the path with all links followed.

    Raises:
        OSError: It cannot be followed; before Python 3.13 a ``RuntimeError`` for links in a circle.
        ValueError: No file can have this path.
    """
    return Path(path).resolve()


@_question
def listed(folder: Path | str) -> list[Listed]:
    """Return the folders and the YAML files in a folder, in the order of their names.

    Raises:
        OSError: It cannot be searched.
    """
    with os.scandir(folder) as entries:
        found = {
            each.name: Listed(each.name, _leads_into(each), each.is_symlink()) for each in entries
        }
    for place, name in map(os.path.split, _unsaved.get()):
        if place == os.path.realpath(folder):
            found.setdefault(name, Listed(name, is_folder=False, is_link=False))
    return sorted(it for it in found.values() if it.is_folder or it.name.endswith(YAML))


def _leads_into(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:
        return False


def opened(path: Path | str) -> BufferedReader:
    """Return a regular file, opened to be read.

    Whoever reads a named pipe or a device may wait forever, and opening a serial port resets its
    board; so these are not opened at all.

    Raises:
        OSError: It cannot be opened, or is no regular file.
        ValueError: No file can have this path.
    """
    content = _content(path) if _listening.get() or _unsaved.get() else None
    if content is None:
        return open_regular(path)
    if len(content) > _LARGEST_NOTED:
        asks_elsewhere()
        return open_regular(path)
    return BufferedReader(cast(Any, BytesIO(content)))


def open_regular(path: Path | str) -> BufferedReader:
    """Return a regular file as `opened` does, and note nothing."""
    _refuse_irregular(path, os.stat(path))  # noqa: PTH116 - a path may be a text
    return open(path, "rb", opener=_without_waiting)


@_question
def _content(path: Path | str) -> bytes:
    written = _unsaved_at(path)
    if written is not None:
        return written
    with open_regular(path) as stream:
        return stream.read(_LARGEST_NOTED + 1)


def replace_file(path: Path, content: bytes | memoryview) -> None:
    """Write a file at once, so that no reader sees half of it and a failure leaves the old one.

    It is written next to the old one, synchronised, and takes its place.

    Args:
        path: The file; a link is replaced, not its target.
        content: All of it.

    Raises:
        OSError: It cannot be written.
    """
    part = path.with_name(f".{path.name[:50]}.{os.urandom(4).hex()}{PART}")
    try:
        with part.open("xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        take_place(part, path)
    finally:
        part.unlink(missing_ok=True)


def take_place(part: Path, path: Path) -> None:
    """Move a file to the place of another one, whose mode it gets; a link is replaced.

    Raises:
        OSError: The other file is read-only, or it is none.
    """
    if is_file(path):
        path.open("r+b").close()  # a file that is read-only stays
        part.chmod(stat.S_IMODE(path.stat().st_mode))
    part.replace(path)


def _without_waiting(path: str, flags: int) -> int:
    """Return a descriptor of a regular file, also if a named pipe has just taken its place."""
    descriptor = os.open(path, flags | _WITHOUT_WAITING)
    try:
        _refuse_irregular(path, os.fstat(descriptor))
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _refuse_irregular(path: Path | str, status: os.stat_result) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))


@_question
def why_hidden(path: Path | str) -> str:
    """Return why it cannot be found out what is at this path; empty if it can."""
    try:
        os.lstat(path)
    except ValueError:
        return ""
    except OSError as error:
        return "" if error.errno in _NOTHING else os.strerror(error.errno or 0)
    return ""
