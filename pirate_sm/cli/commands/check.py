"""`pirate check`: reports what is wrong with robots, missions and pipes.

While nothing has changed the report is printed again before options are even read.
"""

from __future__ import annotations

import sys
from dataclasses import astuple
from typing import TYPE_CHECKING, Any

from pirate_sm.checking.kept_results import again, kept
from pirate_sm.cli import command_line
from pirate_sm.cli.output.terminal import columns_of, shows_colour, writable

if TYPE_CHECKING:
    from pirate_sm.cli.options.checks import CheckOptions

_WHAT = "report"
"""The kind of these results."""


def run_check(options: CheckOptions) -> int:
    """Print the report; return the exit code, which says whether anything was found.

    Raises:
        UsageError: A path does not exist, an option does not fit, or the simulator is needed and
            not installed.
    """
    columns, coloured = _look()

    def afresh() -> tuple[int, str | None]:
        from pirate_sm.cli.commands.fresh_check import fresh_check

        return fresh_check(options, columns, coloured=coloured)

    if options.fix or options.diff or options.rehearse or options.counterexamples is not None:
        code, text = afresh()  # it does more than print
    else:
        inputs = command_line.words or astuple(options), columns, coloured
        code, text = kept(_WHAT, inputs, afresh, _read)
    _show(text)
    return code


def print_again() -> None:
    """Print the kept report of the command line and end the process; return without one."""
    known = again(_WHAT, (command_line.words, *_look()), _read)
    if known is not None:
        command_line.enter(lambda: _print(*known))


def _print(code: int, text: str | None) -> None:
    _show(text)
    raise SystemExit(code)


def _look() -> tuple[int | None, bool]:
    """Return how wide a report is, and whether it is coloured."""
    return columns_of(), shows_colour(sys.stdout)


def _read(found: Any) -> tuple[int, str | None]:
    """Return the exit code and the report from JSON.

    Raises:
        TypeError: It holds something else.
        ValueError: It holds more or less.
    """
    code, text = found
    if not isinstance(code, int) or not isinstance(text, str | None):
        raise TypeError
    return int(code), text


def _show(text: str | None) -> None:
    if text is not None:
        print(writable(text))
