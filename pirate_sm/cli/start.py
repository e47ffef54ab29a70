"""Starts the commands `pirate` and `pirate-run`, and ends their process.

Garbage is not collected while the command line is loaded, because all that is loaded stays (see
`entry.py`).
"""

from __future__ import annotations

import atexit
import gc
import os
import sys
from collections.abc import Callable

from pirate_sm.cli import ctrl_c
from pirate_sm.cli.stored_help import print_stored_help


def main() -> None:
    """Run the command line of `pirate`, and end the process."""
    ctrl_c.leave_to_the_system()
    if print_stored_help(sys.argv):
        return
    _prepare()
    from pirate_sm.cli import entry

    _end(entry.main)


def run_main() -> None:
    """Run the mission on the command line of `pirate-run`, and end the process."""
    ctrl_c.leave_to_the_system()
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


def _end(command: Callable[[], None]) -> None:
    """Run the command; ignore Ctrl-C afterwards, while the process ends."""
    code: object = None
    try:
        _with_room(command)
    except SystemExit as ended:
        code = 0 if ended.code is None else ended.code
        raise
    finally:
        ctrl_c.ignore()
        if isinstance(code, int):
            _exit_at_once(code)


def _exit_at_once(code: int) -> None:
    """End the process as the interpreter does, but leave its memory to the system.

    Freeing every object takes a twentieth of the time of a short mission, and 0.6 s after the
    console. Returns if there are threads to wait for or output cannot be written; then the
    interpreter ends the process.
    """
    import threading

    if any(not each.daemon for each in threading.enumerate()[1:]):
        return
    atexit._run_exitfuncs()
    try:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
    except (OSError, ValueError):
        return
    os._exit(code)


def _with_room(command: Callable[[], None]) -> None:
    """Run the command with all its frames in one chunk of memory."""
    command()


# CPython keeps the frames of Python functions in chunks of 16 KiB. A call that does not fit into
# the chunk maps a new one, and its return unmaps it. Imports are deep enough for that, and then
# each call in them pays. A frame that reserves much gets a larger chunk, which has room
# for the frames above it (decision 96). Unit: words of 8 bytes.
_with_room.__code__ = _with_room.__code__.replace(co_stacksize=20_000)
