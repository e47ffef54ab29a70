"""Names of files: in the folder of a robot, and in messages."""

from __future__ import annotations

from pathlib import Path

PROFILE_FILE = "profile.yaml"


def shown(path: Path) -> str:
    """Return the path for messages: relative where it lies inside the current folder.

    Of a link it is what the link leads to, so that a file has one name; a link that leads nowhere
    has its own.
    """
    try:
        here = Path.cwd()
        whole = path.resolve() if path.exists() else path.absolute()
    except (OSError, RuntimeError, ValueError):
        return str(path).replace("\0", "\\0")
    return str(whole.relative_to(here)) if whole.is_relative_to(here) else str(path)
