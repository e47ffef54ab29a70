"""NO_COLOR and TERM=dumb on a terminal, for every command that writes more than lines."""

from __future__ import annotations

import os
import pty
import re
import select
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
RUN = ("run", "docs/examples/log.yaml", "--backend", "trace", "--no-record", "--speed", "max")
CHECK = ("check", "tests/example_backend/pyproject.toml")
CONSOLE = ("console", "mitre_bend")
COLOURS = re.compile(r"\x1b\[[0-9;]*\b(?:3[0-8]|4[0-8]|9[0-7]|10[0-7])(?:[;m])")


def on_a_terminal(*arguments: str, **environment: str) -> tuple[int, str]:
    """Exit code and everything that the terminal was sent."""
    ours, theirs = pty.openpty()
    inherited = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    process = subprocess.Popen(
        [sys.executable, "-c", "from pirate_sm.cli.entry import main; main()", *arguments],
        stdin=theirs, stdout=theirs, stderr=theirs, cwd=ROOT,
        env={**inherited, "TERM": "xterm-256color", "PYTHONPATH": str(ROOT), **environment},
    )  # fmt: skip
    shown = b""
    while True:
        if select.select([ours], [], [], 0.05)[0]:
            shown += os.read(ours, 65536)
        elif process.poll() is not None:
            break
    os.close(ours)
    os.close(theirs)
    return process.wait(), shown.decode("utf-8", errors="replace")


@pytest.mark.thorough
@pytest.mark.parametrize("command", [RUN, CHECK], ids=["run", "check"])
def test_colours_are_left_out_where_nobody_wants_them(command: tuple[str, ...]) -> None:
    code, shown = on_a_terminal(*command)
    assert COLOURS.search(shown)

    assert on_a_terminal(*command, NO_COLOR="")[1].count("\x1b[") > 0
    without = on_a_terminal(*command, NO_COLOR="1")
    assert without[0] == code
    assert not COLOURS.search(without[1])


@pytest.mark.thorough
@pytest.mark.parametrize("command", [RUN, CHECK], ids=["run", "check"])
def test_a_terminal_that_knows_lines_only_gets_lines_only(command: tuple[str, ...]) -> None:
    _, shown = on_a_terminal(*command, TERM="dumb")
    assert "\x1b" not in shown
    assert shown.strip()


@pytest.mark.thorough
def test_the_console_says_what_a_terminal_lacks() -> None:
    code, shown = on_a_terminal(*CONSOLE, TERM="dumb")
    assert code == 2
    assert "the console needs a terminal" in shown
    assert "\x1b" not in shown
