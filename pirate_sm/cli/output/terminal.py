"""The user's terminal: whether there is one, how wide it is, and whether the user agrees."""

from __future__ import annotations

import os
import re
import select
import sys
from collections.abc import Callable
from typing import TextIO

from pirate_sm.core.errors import UsageError


def is_terminal(stream: object) -> bool:
    """Return whether the stream is a terminal that can do more than lines."""
    isatty = getattr(stream, "isatty", None)
    return bool(isatty and isatty()) and os.environ.get("TERM", "dumb") != "dumb"


def shows_colour(stream: object) -> bool:
    """Return whether the stream is a terminal whose user has not asked for no colours.

    ``NO_COLOR`` asks for none if it is not empty [no-color.org]; rich and the console obey it too.
    """
    return is_terminal(stream) and not os.environ.get("NO_COLOR")


def agree(question: str, nobody: str) -> None:
    """Ask the user at the terminal for consent.

    Args:
        question: The question.
        nobody: The message of the error if there is no terminal.

    Raises:
        UsageError: Nobody has agreed; nothing has moved.
    """
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise UsageError(nobody)
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    if answered_line(lambda: None).strip().lower() not in {"y", "yes"}:
        raise UsageError("nothing has moved")


def answered_line(turn: Callable[[], None], look_s: float = 0.1) -> str:
    """Return the line that the user types at the terminal; empty if the terminal is gone.

    A read would wait on through a signal, so its request to stop would not be seen.

    Args:
        turn: Is called again and again while nothing is typed, to do what must not wait for an
            answer; may raise, to end the wait.
        look_s: How long the terminal is looked at between two turns; 0 if a turn takes its time.
    """
    terminal = sys.stdin.fileno()
    while not select.select([terminal], [], [], look_s)[0]:
        turn()
    try:
        typed = os.read(terminal, 4096)  # a terminal gives one line at a time
    except OSError:
        typed = b""
    turn()
    return typed.decode("utf-8", "replace")


_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LEAST = 20
"""Columns that are left for text after an indent; narrower terminals break lines themselves."""


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
        indent: Spaces before each further line.
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
