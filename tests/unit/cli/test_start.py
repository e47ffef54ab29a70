"""How a command starts and ends: garbage, threads, output, exit functions."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from .conftest import ROOT


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


@pytest.mark.thorough
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
end = os._exit
os._exit = lambda code: os.write(1, b"at once ") and end(code)
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
        pytest.param("", "printed exit function at once ", marks=pytest.mark.thorough),
        (
            "threading.Thread(target=lambda: threading.main_thread().join() or os.write(1, b'th '))"
            ".start()",
            "printed th exit function ",
        ),
        # Nobody waits for a thread such as one that writes to a terminal that takes nothing.
        (
            "threading.Thread(target=threading.Event().wait, daemon=True).start()",
            "printed exit function at once ",
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
