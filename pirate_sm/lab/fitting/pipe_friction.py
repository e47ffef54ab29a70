"""Friction that was found, as a line of a pipe file."""

from __future__ import annotations

import re
from pathlib import Path

from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_pipe

_BLOCK = re.compile(r"^friction:.*\n(?:[ \t]+.*\n)*", re.MULTILINE)


def friction_line(static: float, kinetic: float) -> str:
    """Return the line that gives a pipe this friction."""
    return f"friction: {{static: {max(static, kinetic):.3f}, kinetic: {kinetic:.3f}}}"


def pipe_with_friction(path: Path, static: float, kinetic: float) -> str:
    """Return the text of a pipe file with this friction instead of its own; all else stays.

    Raises:
        LoadError: The file is no pipe.
        UsageError: It cannot be changed line by line.
    """
    _, document = load_pipe(path)
    line, text = f"{friction_line(static, kinetic)}\n", document.text
    text = text if text.endswith("\n") else f"{text}\n"
    if text.lstrip().startswith("{"):
        raise UsageError(f"'{path}' is written in braces: put in by hand {line.strip()}")
    if "friction" in document.data:
        return _BLOCK.sub(line, text, count=1)
    return text + line
