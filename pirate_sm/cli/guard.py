"""Every error of a command becomes one clear message and an exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import suppress

from pirate_sm.errors import PirateError
from pirate_sm.runtime.outcome import BUG, INTERRUPTED
from pirate_sm.runtime.stopping import OUTPUT_LOST


def guarded(work: Callable[[], int], debug: bool) -> int:
    """The exit code of ``work``; what it raised has been said on standard error."""
    try:
        code = work()
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        say("interrupted, nothing has moved")
        return INTERRUPTED
    except BrokenPipeError:
        silence_stdout()
        return OUTPUT_LOST
    except PirateError as error:
        if debug:
            show_traceback(error)
        say(str(error))
        return error.exit_code
    except Exception as error:
        say_bug(error, debug)
        return BUG


def say(message: str) -> None:
    """The message stands on standard error, if anybody still reads it."""
    with suppress(OSError, ValueError):
        print(message, file=sys.stderr, flush=True)


def say_bug(error: BaseException, debug: bool) -> None:
    """One line about a fault of ours, and how to learn more; with ``debug`` the traceback."""
    if debug:
        show_traceback(error)
    hint = "" if debug else "; run again with --debug for the traceback, and please report it"
    say(f"a fault in this program: {type(error).__name__}: {error}{hint}")


def show_traceback(error: BaseException) -> None:
    """Where the error came from stands on standard error."""
    import traceback

    say("".join(traceback.format_exception(error)).rstrip())


def silence_stdout() -> None:
    """Whatever is still to be flushed at exit goes nowhere instead of to a closed pipe."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
