"""What Ctrl-C does, from the start of a command to its end.

Loading the command line takes some tenths of a second. Until it has been read, the system's own
handling of Ctrl-C ends the process.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress

_interrupts: list[int] = []
"""The Ctrl-C that have come in a command that does not move a robot, by their signal."""


def leave_to_the_system() -> None:
    """Let Ctrl-C end the process immediately; one that was ignored from the start stays ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def answer(*, moves: bool) -> None:
    """Say what Ctrl-C does from now on, if it has been left to the system so far.

    A command that moves a robot is ended immediately until it catches signals itself. A
    KeyboardInterrupt would be lost in compiled code, as in Pydantic's while it checks a file: then
    the command would continue, or find faults that are not there.

    Args:
        moves: Whether the command moves a robot; the others get a KeyboardInterrupt.
    """
    if signal.getsignal(signal.SIGINT) == signal.SIG_DFL:
        signal.signal(signal.SIGINT, _leave if moves else _interrupt)


def was_interrupted() -> bool:
    """Return whether Ctrl-C has come in a command that does not move a robot."""
    return bool(_interrupts)


def _interrupt(number: int, _frame: object) -> None:
    """Interrupt the command; it is noted, as compiled code can turn this into another error."""
    _interrupts.append(number)
    raise KeyboardInterrupt


def _leave(number: int, _frame: object) -> None:
    """End the process; nothing has been connected that would have to be closed."""
    with suppress(Exception):  # the signal may have come in the middle of writing
        sys.stdout.flush()
        print("interrupted, nothing has moved", file=sys.stderr, flush=True)
    os._exit(128 + number)  # as a shell shows it


def ignore() -> None:
    """Ignore Ctrl-C while the process ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
