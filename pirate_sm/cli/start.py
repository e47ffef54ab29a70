"""Starts the commands `pirate` and `pirate-run`, or prints stored help, and ends their process.

To make a help text takes six times as long as Python needs to start. `make golden` writes the files
in ``cli/help`` from the options; a test compares them.

Garbage is not collected while the command line is loaded, because all that is loaded stays (see
`entry.py`).
"""

from __future__ import annotations

import atexit
import gc
import os
import sys
from collections.abc import Callable, Sequence

from pirate_sm.cli import ctrl_c

# --- stored help --------------------------------------------------------------------------------


HELP_FOLDER = os.path.join(os.path.dirname(__file__), "help")  # noqa: PTH118, PTH120 - pathlib is slow

WIDEST_HELP = 80
"""Help texts are never wider than this many columns."""


def print_stored_help(arguments: Sequence[str]) -> bool:
    """Print the help text that a command line requests; return whether that was possible.

    It is not possible for other requests, on a narrow terminal, and on one that lacks a sign of the
    text.

    Args:
        arguments: The command line, beginning with the program.
    """
    if len(arguments) < 2 or arguments[-1] not in ("-h", "--help"):
        return False
    name = help_name([os.path.basename(arguments[0]), *arguments[1:-1]])  # noqa: PTH119
    if not (name.replace(".", "").replace("-", "").isalpha() and _fits()):
        return False
    try:
        with open(os.path.join(HELP_FOLDER, name), encoding="utf-8") as file:  # noqa: PTH118, PTH123
            text = file.read()
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError:  # no such command, or output lost: the slow way reports it
        return False
    return True


def help_name(words: Sequence[str]) -> str:
    """Return the name of the file with the help text of a command: its words, with dots."""
    return f"{'.'.join(words)}.txt"


def _fits() -> bool:
    """Return whether standard output has every sign and is wide enough for the text."""
    if sys.stdout is None or sys.stdout.encoding.lower() != "utf-8":
        return False
    try:
        columns = int(os.environ.get("COLUMNS", "0"))
        return (
            columns or os.get_terminal_size(sys.stdout.fileno()).columns or WIDEST_HELP
        ) >= WIDEST_HELP
    except ValueError:
        return False
    except OSError:  # no terminal
        return True


# --- start and end ------------------------------------------------------------------------------


def main() -> None:
    """Run the command line of `pirate`, and end the process."""
    _start("main")


def run_main() -> None:
    """Run the mission on the command line of `pirate-run`, and end the process."""
    _start("run_main")


def _start(command: str) -> None:
    """Print what is stored, or load the command line and run this function of ``entry.py``."""
    ctrl_c.leave_to_the_system()
    if print_stored_help(sys.argv):
        return
    _prepare()

    def work() -> None:
        from pirate_sm.cli import command_line

        with command_line.begun([*(["run"] if command == "run_main" else []), *sys.argv[1:]]):
            from pirate_sm.cli import entry

            getattr(entry, command)()

    _end(work)


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
