"""Asks what is at a path.

The questions of ``pathlib`` raise for some paths and deny that there is anything at others. Here
what is in a folder that may not be entered is there, and neither a file nor a folder: whoever opens
it says why it cannot be read or written. Nothing is at a path that no file can have, such as one
that is too long.
"""

from __future__ import annotations

import errno
import os
import stat
from io import BufferedReader
from pathlib import Path
from secrets import token_hex

PART = ".part"
"""Ending of a file that is not whole yet."""

_NOTHING = {errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG}
"""Errors of a path at which nothing is."""

_WITHOUT_WAITING = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
"""Flags that open a named pipe although nobody writes to it; no system has them all."""


def is_there(path: Path | str) -> bool:
    """Return whether something is at this path, also a broken link, or it cannot be found out."""
    try:
        return os.path.lexists(path) or bool(why_hidden(path))
    except ValueError:
        return False


def is_file(path: Path) -> bool:
    """Return whether a file is known to be at this path."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path | os.DirEntry[str]) -> bool:
    """Return whether a folder is known to be at this path."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def opened(path: Path | str) -> BufferedReader:
    """Return a regular file, opened to be read.

    Whoever reads a named pipe or a device may wait forever, and opening a serial port resets its
    board; so these are not opened at all.

    Raises:
        OSError: It cannot be opened, or is no regular file.
        ValueError: No file can have this path.
    """
    _refuse_irregular(path, os.stat(path))  # noqa: PTH116 - a path may be a text
    return open(path, "rb", opener=_without_waiting)


def replace_file(path: Path, content: bytes | memoryview) -> None:
    """Write a file at once, so that no reader sees half of it and a failure leaves the old one.

    It is written next to the old one, synchronised, and takes its place.

    Args:
        path: The file; a link is replaced, not its target.
        content: All of it.

    Raises:
        OSError: It cannot be written.
    """
    part = path.with_name(f".{path.name[:50]}.{token_hex(4)}{PART}")
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


def why_hidden(path: Path | str) -> str:
    """Return why it cannot be found out what is at this path; empty if it can."""
    try:
        os.lstat(path)
    except ValueError:
        return ""
    except OSError as error:
        return "" if error.errno in _NOTHING else os.strerror(error.errno or 0)
    return ""
