"""Shows the progress of a lengthy task on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from time import monotonic
from typing import Protocol, TextIO

from pirate_sm.cli.output.terminal import columns_of, is_terminal

_FIRST_S = 0.5
"""Shorter tasks show nothing."""

_EVERY_S = 0.1
_CLEARED = "\r\x1b[K"


class Show(Protocol):
    """Shows how far a task is."""

    def __call__(self, share: float, more: str = "", /) -> None:
        """Show the finished share, 0 to 1, and more text."""


@contextmanager
def progress(
    what: str, out: TextIO | None = None, clock: Callable[[], float] = monotonic
) -> Iterator[Show]:
    """Yield a function that takes the finished share, 0 to 1, and shows it on a terminal.

    It may be given more to show, as a second argument.

    The line is removed when the block ends. A smaller share than the last one begins anew.

    Args:
        what: Description of the task.
        out: Output; None: standard error.
        clock: The wall clock, s.
    """
    out = sys.stderr if out is None else out
    if not is_terminal(out):
        yield lambda share, more="": None
        return
    line = _Line(what, out, clock)
    try:
        yield line.show
    finally:
        line.clear()


class _Line:
    """The line on the terminal."""

    def __init__(self, what: str, out: TextIO, clock: Callable[[], float]) -> None:
        self._what, self._out, self._clock = what, out, clock
        self._began_s = clock()
        self._due_s = self._began_s + _FIRST_S
        self._last = 0.0
        self._there = self._over = False

    def show(self, share: float, more: str = "") -> None:
        if self._over:  # something else uses the terminal now
            return
        now_s = self._clock()
        if share < self._last:
            self._began_s = now_s
        self._last = share
        if now_s < self._due_s:
            return
        self._due_s = now_s + _EVERY_S
        self._there = True
        line = f"{self._what}: {share:.0%}{more}{self._left(share, now_s)}"
        self._write(_CLEARED + line[: columns_of(self._out)])

    def clear(self) -> None:
        self._over = True
        if self._there:
            self._write(_CLEARED)

    def _left(self, share: float, now_s: float) -> str:
        """Return the approximate remaining time; empty if it is uncertain or short."""
        taken_s = now_s - self._began_s
        left_s = taken_s * (1 / share - 1) if share > 0 else 0.0
        if taken_s < 1.0 or left_s < 1.0:
            return ""
        minutes, seconds = divmod(round(left_s), 60)
        return f", {minutes}:{seconds:02d} min left" if minutes else f", {seconds} s left"

    def _write(self, text: str) -> None:
        with suppress(OSError, ValueError):
            self._out.write(text)
            self._out.flush()
