"""Asks what is at a path.

The questions of ``pathlib`` raise for some paths and deny that there is anything at others. Here
what is in a folder that may not be entered is there, and neither a file nor a folder: whoever opens
it says why it cannot be read or written. Nothing is at a path that no file can have, such as one
that is too long.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path

_NOTHING = {errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG}
"""Errors of a path at which nothing is."""


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


def why_hidden(path: Path | str) -> str:
    """Return why it cannot be found out what is at this path; empty if it can."""
    try:
        os.lstat(path)
    except ValueError:
        return ""
    except OSError as error:
        return "" if error.errno in _NOTHING else os.strerror(error.errno or 0)
    return ""
