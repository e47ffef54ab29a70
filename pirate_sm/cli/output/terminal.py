"""The terminal that a person looks at: whether there is one, and whether that person agrees."""

from __future__ import annotations

import os
import sys

from pirate_sm.errors import UsageError


def is_terminal(stream: object) -> bool:
    """Whether a person sees the stream, on something that can do more than lines."""
    isatty = getattr(stream, "isatty", None)
    return bool(isatty and isatty()) and os.environ.get("TERM", "dumb") != "dumb"


def agree(question: str, nobody: str) -> None:
    """Ask a person at the terminal for consent.

    Args:
        question: What is asked.
        nobody: The message of the error where there is nobody to ask.

    Raises:
        UsageError: Nobody has agreed; nothing has moved.
    """
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise UsageError(nobody)
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in {"y", "yes"}:
        raise UsageError("nothing has moved")
