"""File names: those in a robot's folder, and paths in messages."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.core.on_disk import is_file, is_folder

PROFILE_FILE = "profile.yaml"


def shown(path: Path) -> str:
    """Return the path for messages, relative if it is inside the current folder.

    A symbolic link is resolved, so that a file has only one name; a broken link keeps its own.
    """
    try:
        here = Path.cwd()
        whole = path.resolve() if is_file(path) or is_folder(path) else path.absolute()
    except (OSError, RuntimeError, ValueError):
        return str(path).replace("\0", "\\0")
    return str(whole.relative_to(here)) if whole.is_relative_to(here) else str(path)
