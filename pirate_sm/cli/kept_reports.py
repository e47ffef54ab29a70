"""Prints the report of a check again while nothing has changed, before options are even read."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

from pirate_sm.checking.kept_results import again, kept_results
from pirate_sm.cli.output.terminal import columns_of, degrade, shows_colour, writable

WHAT = "report"
"""The kind of these results."""

line: tuple[str, ...] = ()
"""The command line of this process, from which all its options follow; empty if it has none."""


def look() -> tuple[int | None, bool]:
    """Return how wide a report is, and whether it is coloured."""
    return columns_of(), shows_colour(sys.stdout)


def read(found: Any) -> tuple[int, str | None]:
    """Return the exit code and the report from JSON.

    Raises:
        TypeError: It holds something else.
        ValueError: It holds more or less.
    """
    code, text = found
    if not isinstance(code, int) or not isinstance(text, str | None):
        raise TypeError
    return int(code), text


def show(text: str | None) -> None:
    """Print a report, if there is one."""
    if text is not None:
        print(writable(text))


def print_again(arguments: Sequence[str]) -> None:
    """Print the kept report of a command line and end the process; return without one.

    Args:
        arguments: The command line after the program.
    """
    global line  # noqa: PLW0603 - a process has one
    line = tuple(arguments)
    if sys.stdout is None:
        return
    with kept_results():
        found = again(WHAT, (line, *look()), read)
    if found is None:
        return
    code, text = found
    degrade(sys.stdout)
    try:
        show(text)
        sys.stdout.flush()
    except OSError as error:
        from pirate_sm.cli.errors import output_lost

        code = output_lost(error)
    raise SystemExit(code)
