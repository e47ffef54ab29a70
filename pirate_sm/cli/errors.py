"""Turns every error of a command into one message and an exit code."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable
from contextlib import suppress

from pirate_sm.errors import PirateError
from pirate_sm.runtime.outcome import BUG, INTERRUPTED
from pirate_sm.runtime.stop_requests import OUTPUT_LOST
from pirate_sm.visible import visible

_LOST = {errno.EPIPE, errno.ENOSPC, errno.EBADF}
"""Exceptions from writing to a standard output that is closed or full."""


def guarded(work: Callable[[], int], debug: bool, *, moves: bool = False) -> int:
    """Do the work and return its exit code; print its exceptions on standard error.

    Args:
        work: The work of a command.
        debug: Whether tracebacks are printed.
        moves: Whether the command moves a robot; while it does, the run handles Ctrl-C itself.
    """
    try:
        code = work()
        sys.stdout.flush()
        return code
    except KeyboardInterrupt as interrupted:
        usual = "interrupted, nothing has moved" if moves else "interrupted"
        say(str(interrupted) or usual)
        return INTERRUPTED
    except BrokenPipeError:
        silence_stdout()
        return OUTPUT_LOST
    except OSError as error:
        if error.errno not in _LOST:
            say_bug(error, debug)
            return BUG
        return output_lost(error)
    except PirateError as error:
        if debug:
            show_traceback(error)
        say(error.for_terminal)
        return error.exit_code
    except Exception as error:
        say_bug(error, debug)
        return BUG


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
    say(f"a fault in this program: {type(error).__name__}: {error}{hint}")


def show_traceback(error: BaseException) -> None:
    """Print the traceback of the error to standard error."""
    import traceback

    say("".join(traceback.format_exception(error)).rstrip())


def output_lost(error: OSError) -> int:
    """Print that standard output cannot be written; return the exit code for that."""
    silence_stdout()
    say(f"the output cannot be written: {error.strerror}")
    return OUTPUT_LOST


def silence_stdout() -> None:
    """Discard output that is still to be flushed at exit, instead of writing to a closed pipe."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
