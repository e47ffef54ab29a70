"""Lines that are broken between words where a terminal ends; piped lines stay whole."""

from __future__ import annotations

import os
import re
import sys
from typing import TextIO

from pirate_sm.cli.output.terminal import is_terminal

_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LEAST = 20
"""Columns that are left for text beside an indent; narrower terminals break lines themselves."""


def columns_of(stream: TextIO | None = None) -> int | None:
    """Return the width of a terminal, by default standard output; None if the stream is none."""
    stream = sys.stdout if stream is None else stream
    if not is_terminal(stream):
        return None
    try:
        return os.get_terminal_size(stream.fileno()).columns or None
    except (OSError, ValueError):
        return None


def wrapped(line: str, columns: int | None, indent: int = 2) -> str:
    """Return a line broken between words, where no word is wider than what is left for it.

    Args:
        line: The line; colours have no width.
        columns: Where to break it; None for nowhere.
        indent: Blanks before each further line.
    """
    if columns is None or _width(line) <= columns or columns - indent < _LEAST:
        return line
    lines, now = [], ""
    for word in re.split(r"(?<=\S)(?= )", line):
        if now and _width(now) + _width(word) > columns:
            lines.append(now)
            now = " " * indent + word.lstrip(" ")
        else:
            now += word
    return "\n".join([*lines, now])


def _width(text: str) -> int:
    return len(_COLOUR.sub("", text))
