"""Prints stored help texts: to make one takes six times as long as Python needs to start.

`make golden` writes the files in ``cli/help`` from the options; a test compares them.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

FOLDER = os.path.join(os.path.dirname(__file__), "help")  # noqa: PTH118, PTH120 - pathlib is slow

WIDEST = 80
"""Help texts are never wider than this many columns."""


def print_stored_help(arguments: Sequence[str]) -> bool:
    """Print the help text that a command line requests; return whether that was possible.

    It is not possible for other requests, on a narrow terminal, and on one that lacks a sign of the
    text.

    Args:
        arguments: The command line, beginning with the program.
    """
    if len(arguments) < 2 or arguments[-1] not in ("-h", "--help"):
        return False
    name = help_name([os.path.basename(arguments[0]), *arguments[1:-1]])  # noqa: PTH119
    if not (name.replace(".", "").replace("-", "").isalpha() and _fits()):
        return False
    try:
        with open(os.path.join(FOLDER, name), encoding="utf-8") as file:  # noqa: PTH118, PTH123
            text = file.read()
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError:  # no such command, or output lost: the slow way reports it
        return False
    return True


def help_name(words: Sequence[str]) -> str:
    """Return the name of the file with the help text of a command: its words, with dots."""
    return f"{'.'.join(words)}.txt"


def _fits() -> bool:
    """Return whether standard output has every sign and is wide enough for the text."""
    if sys.stdout is None or sys.stdout.encoding.lower() != "utf-8":
        return False
    try:
        columns = int(os.environ.get("COLUMNS", "0"))
        return (columns or os.get_terminal_size(sys.stdout.fileno()).columns or WIDEST) >= WIDEST
    except ValueError:
        return False
    except OSError:  # no terminal
        return True
