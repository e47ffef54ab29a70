"""The console on a terminal of its own: however it ends, the terminal is as it was."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path

import pytest

PIRATE = Path(sys.executable).with_name("pirate")
NORMAL_SCREEN, CURSOR = "\x1b[?1049l", "\x1b[?25h"

pytestmark = pytest.mark.slow  # real terminals, in real time


class Terminal:
    """A pseudo-terminal with the console in it."""

    def __init__(self, folder: Path) -> None:
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.environ.update(TERM="xterm-256color", PIRATE_SM_RUNS="runs")
            os.execv(PIRATE, ["pirate", "console", "mitre_bend"])
        fcntl.ioctl(self.fd, termios.TIOCSWINSZ, struct.pack("HHHH", 48, 160, 0, 0))
        self.shown = ""

    def read_until(self, word: str, within_s: float = 30.0) -> None:
        give_up_s = time.monotonic() + within_s
        while word not in self.shown:
            assert time.monotonic() < give_up_s, f"'{word}' is not shown"
            if select.select([self.fd], [], [], 0.05)[0]:
                self.shown += os.read(self.fd, 65536).decode("utf-8", "replace")

    def press(self, keys: str) -> None:
        os.write(self.fd, keys.encode())

    def code(self) -> int:
        """Its exit code; what is left to be read has been read."""
        while True:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            try:
                if select.select([self.fd], [], [], 0.05)[0]:
                    self.shown += os.read(self.fd, 65536).decode("utf-8", "replace")
            except OSError:
                pass  # the other end has gone
            if pid:
                return os.waitstatus_to_exitcode(status)


ENDS: dict[str, tuple[Callable[[Terminal], None], int, str]] = {
    "q": (lambda there: there.press("q"), 0, "the console was left"),
    "ctrl-c": (lambda there: there.press("\x03"), 0, "the console was left"),
    "SIGTERM": (lambda there: os.kill(there.pid, signal.SIGTERM), 143, "(SIGTERM)"),
    "SIGHUP": (lambda there: os.kill(there.pid, signal.SIGHUP), 129, "(SIGHUP)"),
}


@pytest.mark.parametrize("end", ENDS)
def test_every_way_out_ends_in_the_safe_state_with_the_terminal_as_it_was(
    end: str, tmp_path: Path
) -> None:
    there = Terminal(tmp_path)
    there.read_until("PAUSED")
    there.press("c")
    there.read_until("under way")
    leave, code, sentence = ENDS[end]
    leave(there)

    assert there.code() == code
    last = there.shown[there.shown.rindex(NORMAL_SCREEN) :]
    assert CURSOR in last
    assert f"{sentence}: safe state, wheels stopped and clamps held" in last
    assert list((tmp_path / "runs").glob("*.mcap"))


def test_a_terminal_that_is_closed_ends_in_the_safe_state(tmp_path: Path) -> None:
    there = Terminal(tmp_path)
    there.read_until("PAUSED")
    os.close(there.fd)
    for _ in range(400):
        pid, status = os.waitpid(there.pid, os.WNOHANG)
        if pid:
            break
        time.sleep(0.05)

    assert pid
    assert os.waitstatus_to_exitcode(status) == 129
