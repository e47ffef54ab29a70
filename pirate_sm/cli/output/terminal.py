"""The user's terminal: what it can show, how wide it is, whether the user agrees, and progress."""

from __future__ import annotations

import codecs
import os
import re
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from time import monotonic
from typing import Protocol, TextIO

from pirate_sm.core.errors import UsageError

# --- the terminal -------------------------------------------------------------------------------


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


# --- progress -----------------------------------------------------------------------------------


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

    The line is removed when the block ends. A smaller share than the last one starts again.

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


# --- signs that an encoding lacks ---------------------------------------------------------------


_ALIKE = {
    "→": "->", "←": "<-", "×": "x", "°": " deg", "−": "-", "–": "-", "—": "-", "…": "...",
    "✓": "v", "✕": "x", "●": "*", "○": "o", "◐": "o", "◆": "*", "■": "#", "▶": ">", "▷": ">",
    "‖": "||", "⚠": "!", "⌀": "diameter", "─": "-", "━": "=", "│": "|", "├": "|", "└": "`",
}  # fmt: skip
"""Replacements for signs that the encoding lacks; a question mark for any other."""


def shows_signs(stream: TextIO | None) -> bool:
    """Return whether the stream's encoding has every sign of the pictures."""
    try:
        "→●⣿━".encode(getattr(stream, "encoding", None) or "ascii")
    except UnicodeEncodeError:
        return False
    return True


def degrade(stream: TextIO | None) -> None:
    """Make the stream replace signs that its encoding lacks."""
    if stream is not None and not shows_signs(stream) and hasattr(stream, "reconfigure"):
        codecs.register_error("alike", _alike)
        stream.reconfigure(errors="alike")


def writable(text: str) -> str:
    """Return the text with signs written out that the encoding of standard output lacks."""
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    return text.encode(encoding, "backslashreplace").decode(encoding)


def _alike(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_ALIKE.get(each, "?") for each in lacking), error.end
