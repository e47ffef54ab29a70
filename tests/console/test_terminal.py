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

LOOKED_AT = "it is so already"
"""Is shown when commands are accepted."""

pytestmark = pytest.mark.slow  # real terminals, in real time


class Terminal:
    """A pseudo-terminal with the console in it.

    Args:
        folder: The working directory.
        shows: The mission or the recording.
        deaf: Whether nobody tells the console of a lost terminal.
        program: Starts the console in another way than its command does.
    """

    def __init__(
        self, folder: Path, shows: str = "mitre_bend", *, deaf: bool = False, program: str = ""
    ) -> None:
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.environ.update(TERM="xterm-256color", PIRATE_SM_RUNS="runs")
            if deaf:
                signal.signal(signal.SIGHUP, signal.SIG_IGN)
            if program:
                os.execv(sys.executable, [sys.executable, "-c", program, "console", shows])
            os.execv(PIRATE, ["pirate", "console", shows])
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
    there.read_until(LOOKED_AT)
    there.press("c")
    there.read_until("under way")
    leave, code, sentence = ENDS[end]
    leave(there)

    assert there.code() == code
    last = there.shown[there.shown.rindex(NORMAL_SCREEN) :]
    assert CURSOR in last
    assert f"{sentence}: wheels set to zero; front clamped (" in last
    assert list((tmp_path / "runs").glob("*.mcap"))


SLOWLY_STARTED = """
import time

from pirate_sm.cli.entry import main
from pirate_sm.views.console.check_process import CheckProcess

right = CheckProcess.__enter__


def slow(self):
    print("being started", flush=True)
    time.sleep(1.0)
    return right(self)


CheckProcess.__enter__ = slow
main()
"""


def test_a_key_that_is_typed_before_anything_is_shown_does_nothing(tmp_path: Path) -> None:
    there = Terminal(tmp_path, program=SLOWLY_STARTED)
    there.read_until("being started")
    there.press("?")
    there.read_until(LOOKED_AT)
    until_s = time.monotonic() + 2.0
    while time.monotonic() < until_s:
        if select.select([there.fd], [], [], 0.05)[0]:
            there.shown += os.read(there.fd, 65536).decode("utf-8", "replace")
    assert "Esc leaves" not in there.shown

    there.press("?")
    there.read_until("Esc leaves")
    os.kill(there.pid, signal.SIGTERM)
    assert there.code() == 143


STATES: dict[str, tuple[str, str]] = {
    "paused": ("", "PAUSED"),
    "running": ("r", "RUNNING"),
    "a list": ("m", "Esc leaves"),
    "the help page": ("?", "Esc leaves"),
    "leaving": ("q", ""),
}


def ended(there: Terminal) -> int:
    """Its exit code; nobody reads what it writes."""
    for _ in range(400):
        pid, status = os.waitpid(there.pid, os.WNOHANG)
        if pid:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.05)
    os.kill(there.pid, signal.SIGKILL)
    os.waitpid(there.pid, 0)
    raise AssertionError("it is still there")


@pytest.mark.parametrize("deaf", [False, True], ids=["with a signal", "without a signal"])
@pytest.mark.parametrize("state", STATES)
def test_a_terminal_that_is_closed_ends_the_console(state: str, deaf: bool, tmp_path: Path) -> None:
    there = Terminal(tmp_path, deaf=deaf)
    there.read_until(LOOKED_AT)
    key, sign = STATES[state]
    there.press(key)
    there.read_until(sign)
    os.close(there.fd)

    assert ended(there) in ((0, 129) if state == "leaving" else (129,))


@pytest.mark.parametrize("end", ["q", "SIGTERM"])
def test_a_terminal_that_takes_no_more_output_does_not_keep_the_console(
    end: str, tmp_path: Path
) -> None:
    there = Terminal(tmp_path)
    there.read_until(LOOKED_AT)
    there.press("r")
    time.sleep(5.0)  # what it writes fills the terminal, which is what this is about
    leave, code, _ = ENDS[end]
    leave(there)

    assert ended(there) == code


@pytest.mark.parametrize("end", ["close", "SIGTERM"])
def test_a_recording_is_left_when_its_terminal_goes(end: str, tmp_path: Path) -> None:
    first = Terminal(tmp_path)
    first.read_until(LOOKED_AT)
    first.press("c")
    first.read_until("under way")
    first.press("q")
    assert first.code() == 0
    (recording,) = (tmp_path / "runs").glob("*.mcap")

    there = Terminal(tmp_path, str(recording), deaf=True)
    there.read_until("RECORDING")
    if end == "close":
        os.close(there.fd)
        assert ended(there) == 129
    else:
        os.kill(there.pid, signal.SIGTERM)
        assert there.code() == 143
        assert CURSOR in there.shown[there.shown.rindex(NORMAL_SCREEN) :]
