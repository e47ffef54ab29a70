"""Turns every error of a command, and a stop, into one message and an exit code."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from pirate_sm.cli.ctrl_c import was_interrupted
from pirate_sm.core.errors import ExitCode, PirateError
from pirate_sm.core.visible import visible

if TYPE_CHECKING:
    from pirate_sm.running.runtime.ending import Stop, StopRequests


class StoppedError(Exception):
    """Is raised to end a command when a stop is requested."""

    def __init__(self, stop: Stop) -> None:
        super().__init__(stop.reason)
        self.exit_code = stop.exit_code


def stopper(requests: StopRequests) -> Callable[[], None]:
    """Return a check that raises once when a stop is requested; cleaning up is then undisturbed."""
    raised = False

    def check() -> None:
        nonlocal raised
        if requests.stop is not None and not raised:
            raised = True
            raise StoppedError(requests.stop)

    return check


_LOST = {errno.EPIPE, errno.ENOSPC, errno.EBADF}
"""Exceptions from writing to a standard output that is closed or full."""


_FAULTS = range(1, 128)
"""Exit codes of a command that was not stopped."""


def guarded(work: Callable[[], int], debug: bool) -> int:
    """Do the work and return its exit code; print its exceptions on standard error.

    Args:
        work: The work of a command.
        debug: Whether tracebacks are printed.
    """
    try:
        code = work()
        sys.stdout.flush()
        return ExitCode.INTERRUPTED if code in _FAULTS and was_interrupted() else code
    except KeyboardInterrupt as interrupted:
        say(str(interrupted) or "interrupted")
        return ExitCode.INTERRUPTED
    except Exception as error:
        if was_interrupted():  # the interrupt has become this error
            say("interrupted")
            return ExitCode.INTERRUPTED
        return _reported(error, debug)


def _reported(error: Exception, debug: bool) -> int:
    """Print an error in words for its kind; return the exit code."""
    if isinstance(error, BrokenPipeError):
        silence_stdout()
        return ExitCode.OUTPUT_LOST
    if isinstance(error, OSError) and error.errno in _LOST:
        return output_lost(error)
    if isinstance(error, StoppedError):
        say(f"{error}; nothing has moved")
        return error.exit_code
    if isinstance(error, PirateError):
        if debug:
            show_traceback(error)
        say(error.for_terminal)
        return error.exit_code
    say_bug(error, debug)
    return ExitCode.BUG


def say(message: str) -> None:
    """Print the message to standard error, if that is still open."""
    if sys.stderr is None:  # it was closed from the start
        return
    with suppress(OSError, ValueError):
        print(visible(message, lines=True), file=sys.stderr, flush=True)


def say_bug(error: BaseException, debug: bool) -> None:
    """Print that this program has a fault and how to learn more; with ``debug`` the traceback."""
    if debug:
        show_traceback(error)
    hint = "" if debug else "; run again with --debug for the traceback, and please report it"
    say(f"an internal error: {type(error).__name__}: {error}{hint}")


def show_traceback(error: BaseException) -> None:
    """Print the traceback of the error to standard error."""
    import traceback

    say("".join(traceback.format_exception(error)).rstrip())


def output_lost(error: OSError) -> int:
    """Print that standard output cannot be written; return the exit code for that."""
    silence_stdout()
    say(f"the output cannot be written: {error.strerror}")
    return ExitCode.OUTPUT_LOST


def silence_stdout() -> None:
    """Discard output that is still to be flushed at exit, instead of writing to a closed pipe."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
