"""The user's terminal: whether there is one, and whether the user agrees."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable

from pirate_sm.errors import UsageError


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
