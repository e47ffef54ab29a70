"""Starts the commands `pirate` and `pirate-run`, without a traceback for an early Ctrl-C.

Loading the command line takes some tenths of a second. Until it can answer Ctrl-C with a sentence,
the system's own handling ends the process without a traceback. Nothing has moved by then. Garbage
is not collected meanwhile either, because all that is loaded stays (see `entry.py`).
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from pirate_sm.cli.stored_help import print_stored_help


def main() -> None:
    """Run the command line of `pirate`, and end the process."""
    with _ctrl_c_without_traceback():
        if print_stored_help(sys.argv):
            return
        _prepare()
        from pirate_sm.cli import entry
    _end(entry.main)


def run_main() -> None:
    """Run the mission on the command line of `pirate-run`, and end the process."""
    with _ctrl_c_without_traceback():
        if print_stored_help(sys.argv):
            return
        _prepare()
        from pirate_sm.cli import entry
    _end(entry.run_main)


def _prepare() -> None:
    """Set what must be set before anything is loaded.

    NumPy's OpenBLAS starts a thread for each processor, which waits busily for matrices: a tenth of
    the processor time of a short mission on two processors. No matrix here is large, and on a busy
    machine these threads wait for each other far longer than the matrices take. Pydantic looks
    through all that is installed for plugins, which could change how files are checked.
    """
    gc.disable()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")


@contextmanager
def _ctrl_c_without_traceback() -> Iterator[None]:
    """Let Ctrl-C end the process at once; one that was ignored from the start stays ignored."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGINT, before)


def _end(command: Callable[[], None]) -> None:
    """Run the command; ignore Ctrl-C afterwards, while the interpreter shuts down."""
    try:
        _with_room(command)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _with_room(command: Callable[[], None]) -> None:
    """Run the command with all its frames in one chunk of memory."""
    command()


# CPython keeps the frames of Python functions in chunks of 16 KiB. A call that does not fit into
# the chunk maps a new one, and its return unmaps it. Imports are deep enough for that, and then
# each call in them pays. A frame that reserves much gets a larger chunk, which has room
# for the frames above it (decision 96). Unit: words of 8 bytes.
_with_room.__code__ = _with_room.__code__.replace(co_stacksize=20_000)
