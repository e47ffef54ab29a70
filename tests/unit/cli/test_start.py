"""Ctrl-C at any moment: no traceback, and nothing said that is not so."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from pirate_sm.cli import start

from .conftest import NEWT, ROOT


def test_ctrl_c_while_the_commands_are_loaded_ends_the_process_without_a_traceback() -> None:
    code = """
import signal, sys
class Interrupts:
    def find_spec(self, name, path=None, target=None):
        if name == "typer":
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, Interrupts())
from pirate_sm.cli.start import run_main
run_main()
"""
    result = subprocess.run(
        [sys.executable, "-c", code, str(NEWT / "patrol.yaml")],
        capture_output=True, text=True, check=False, timeout=60,
        env={"PYTHONPATH": str(ROOT), "PATH": ""},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip

    assert result.returncode == -signal.SIGINT
    assert result.stderr == ""


@pytest.mark.parametrize(
    ("command", "becomes", "says"),
    [
        ("run", "raise", "interrupted, nothing has moved\n"),
        ("run", "raise RuntimeError", "interrupted, nothing has moved\n"),
        ("run", "pass", "interrupted, nothing has moved\n"),
        ("check", "raise", "interrupted\n"),
        ("check", "raise RuntimeError", "interrupted\n"),
    ],
)
def test_ctrl_c_while_a_file_is_read_ends_the_command(
    command: str, becomes: str, says: str
) -> None:
    """Compiled code that checks a file may turn the exception into another one, or drop it."""
    code = f"""
import signal
import pirate_sm.loading.yaml.document as document
read = document.read_document
def interrupted(*given, **more):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        {becomes}
    return read(*given, **more)
document.read_document = interrupted
from pirate_sm.cli.start import main
main()
"""
    result = subprocess.run(
        [sys.executable, "-c", code, command, str(NEWT / "patrol.yaml")],
        capture_output=True, text=True, check=False, timeout=60,
        env={"PYTHONPATH": str(ROOT), "PATH": ""},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip

    assert (result.returncode, result.stdout, result.stderr) == (130, "", says)


def test_ctrl_c_is_ignored_once_the_command_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr("pirate_sm.cli.entry.main", lambda: None)
    try:
        start.main()
        signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


def test_garbage_is_collected_again_when_a_command_works() -> None:
    code = """
import gc, sys
import pirate_sm.cli.commands.list as work
work.list_things = lambda options: print(gc.isenabled(), gc.get_freeze_count() > 1000) or 0
sys.argv = ["pirate", "list"]
from pirate_sm.cli.start import main
main()
"""
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )

    assert told.stdout == "True True\n"


@pytest.mark.parametrize(("given", "threads"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_numpy_starts_no_threads_unless_they_are_asked_for(
    given: dict[str, str], threads: str
) -> None:
    code = """
import os, sys
import pirate_sm.cli.commands.list as work
work.list_things = lambda options: print(os.environ["OPENBLAS_NUM_THREADS"]) or 0
sys.argv = ["pirate", "list"]
from pirate_sm.cli.start import main
main()
"""
    rest = {name: each for name, each in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    printed = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True, text=True, check=True, cwd=ROOT, env=rest | given,
    )  # fmt: skip

    assert printed.stdout == f"{threads}\n"


_ENDS = """
import atexit, os, sys, threading
import pirate_sm.cli.commands.list as work
def list_things(options):
    atexit.register(os.write, 1, b"exit function ")
    sys.stdout.write("printed ")
    {more}
    return 3
work.list_things = list_things
sys.argv = ["pirate", "list"]
from pirate_sm.cli.start import main
main()
"""


@pytest.mark.parametrize(
    ("more", "printed"),
    [
        ("", "printed exit function "),
        (
            "threading.Thread(target=lambda: threading.main_thread().join() or os.write(1, b'th '))"
            ".start()",
            "printed th exit function ",
        ),
    ],
)
def test_a_command_ends_after_its_output_its_threads_and_its_exit_functions(
    more: str, printed: str
) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", _ENDS.format(more=more)],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip

    assert (ended.returncode, ended.stdout, ended.stderr) == (3, printed, "")
