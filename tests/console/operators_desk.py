"""An operator's desk in real time: the emulated bay, a cable that can be pulled, and a terminal."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
import tty
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

from pirate_sm.running.wiring import Order, load

from .screen import Screen

PIRATE = "from pirate_sm.cli.entry import main; main()"
LAG_S = 2.0
"""What is shown may be this much older than what is so: frames, echoes, and a busy computer."""

KNOWN_S = 1.5
"""By then a silence is on the screen."""

ROBOT = load(Order("mitre_bend")).robot
WHEELS = sorted(ROBOT.safe_zero)


class Cable:
    """The cable from the host to the bay; it can be pulled and put in again.

    The host opens a pseudo-terminal of its own. As long as it has it open, the bay's is open.
    """

    def __init__(self, port: str, link: Path) -> None:
        self.link, self._port = link, port
        self._host = self._bay = -1
        self.pulled_s: float | None = None
        self._wanted = self._leaving = False
        self._thread = Thread(target=self._carry, daemon=True)
        self.plug()
        self._thread.start()

    def plug(self) -> None:
        """Put it in."""
        self._wanted, self.pulled_s = True, None

    def pull(self) -> None:
        """Pull it out: the host's port has gone, and the controller keeps its power."""
        self._wanted, self.pulled_s = False, time.monotonic()

    def close(self) -> None:
        """Take it away."""
        self._leaving = True
        self._thread.join(5.0)

    def _carry(self) -> None:
        while not self._leaving:
            if self._wanted and self._host < 0:
                self._make()
            elif not self._wanted and self._host >= 0:
                self._cut()
            if self._host < 0:
                time.sleep(0.01)
                continue
            self._pass_on()
        self._cut()

    def _make(self) -> None:
        self._host, theirs = os.openpty()
        tty.setraw(theirs)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(theirs))
        os.close(theirs)

    def _cut(self) -> None:
        self.link.unlink(missing_ok=True)
        for each in (self._host, self._bay):
            if each >= 0:
                os.close(each)
        self._host = self._bay = -1

    def _pass_on(self) -> None:
        poll = select.poll()
        poll.register(self._host, select.POLLIN)
        events = dict(poll.poll(2)).get(self._host, 0)
        if events & select.POLLHUP:  # the host does not have it open
            if self._bay >= 0:
                os.close(self._bay)
                self._bay = -1
            time.sleep(0.005)
            return
        if self._bay < 0:
            self._bay = os.open(self._port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            tty.setraw(self._bay)
        for one, other in ((self._host, self._bay), (self._bay, self._host)):
            if select.select([one], [], [], 0)[0]:
                with suppress(OSError):
                    os.write(other, os.read(one, 4096))


class Bay:
    """The emulated bay, whose log says what is so."""

    def __init__(self, folder: Path) -> None:
        self._log = folder / "bay.jsonl"
        options = ("bay", "--mission", "mitre_bend", "--log", str(self._log))
        self.process = subprocess.Popen(
            [sys.executable, "-c", PIRATE, *options], stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.port = self.process.stdout.readline().strip()
        self._read = 0
        self._rest = ""
        self.in_force: list[int] = [0] * len(ROBOT.slots)
        self.trips = 0
        self.frozen_s: float | None = None

    def freeze(self) -> None:
        """Let the controller hang: its motors go on."""
        self.frozen_s = time.monotonic()
        os.kill(self.process.pid, signal.SIGSTOP)

    def thaw(self) -> None:
        """Let it go on."""
        self.frozen_s = None
        os.kill(self.process.pid, signal.SIGCONT)

    def close(self) -> None:
        """Take it away."""
        self.process.kill()
        self.process.communicate()

    @property
    def drives(self) -> bool:
        """Whether a wheel is driven."""
        return any(self.in_force[slot] for slot in WHEELS)

    def look(self) -> None:
        """Read what has happened."""
        if not self._log.exists():
            return
        with self._log.open(encoding="utf-8") as file:
            file.seek(self._read)
            text = self._rest + file.read()
            self._read = file.tell()
        *lines, self._rest = text.split("\n")
        for each in lines:
            self._take(json.loads(each))

    def _take(self, record: dict[str, Any]) -> None:
        if record["event"] in ("applied", "tripped"):
            self.in_force = record["setpoints"]
            self.trips += record["event"] == "tripped"
        elif record["event"] == "booted":
            self.in_force = [0] * len(self.in_force)


class Desk:
    """The console on a terminal; what it shows is compared with the bay at every look."""

    def __init__(self, folder: Path, size: tuple[int, int], bay: Bay, cable: Cable) -> None:
        self.folder, self.size, self.bay, self.cable = folder, size, bay, cable
        self.pid = self.fd = -1
        self.screen = Screen(*size)
        self._drove: deque[tuple[float, bool]] = deque()
        self._heard_s = time.monotonic()
        self.looks = 0

    def open(self, *arguments: str) -> None:
        """Start the console on the cable."""
        port = () if arguments[-1:] and arguments[-1].endswith(".mcap") else self._port()
        self.screen = Screen(*self.size)
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(self.folder)
            left_out = ("NO_COLOR", "COLUMNS", "LINES")
            there = {name: each for name, each in os.environ.items() if name not in left_out}
            there |= {"TERM": "xterm-256color", "PIRATE_SM_RUNS": "runs"}
            command = [sys.executable, "-c", PIRATE, "console", *arguments, *port]
            os.execve(sys.executable, command, there)
        fcntl.ioctl(self.fd, termios.TIOCSWINSZ, struct.pack("HHHH", *self.size[::-1], 0, 0))

    def _port(self) -> tuple[str, ...]:
        return ("--backend", "serial", "--port", str(self.cable.link))

    @property
    def text(self) -> str:
        return self.screen.text()

    def press(self, keys: str) -> None:
        os.write(self.fd, keys.encode())

    def until(self, what: str | Callable[[], object], within_s: float = 30.0) -> None:
        """Look until it is shown, or so; every look is compared with the bay."""
        give_up_s = time.monotonic() + within_s
        while not (what in self.text if isinstance(what, str) else what()):
            assert time.monotonic() < give_up_s, f"{what!r} is not shown:\n{self.text}"
            self.look()

    def wait(self, seconds: float) -> None:
        """Look for so long."""
        until_s = time.monotonic() + seconds
        self.until(lambda: time.monotonic() >= until_s, seconds + 10)

    def look(self) -> None:
        """Read the terminal and the bay's log, and compare them."""
        quiet = self._read_all()
        self.bay.look()
        now_s = time.monotonic()
        self._drove.append((now_s, self.bay.drives))
        while self._drove[0][0] < now_s - LAG_S:
            self._drove.popleft()
        self.looks += 1
        if not quiet:
            return  # half of a frame says nothing
        for wrong in self._untrue(now_s):
            raise AssertionError(f"{wrong}:\n{self.text}")

    def _read_all(self) -> bool:
        """Read until nothing more is written; return whether that was soon."""
        give_up_s = time.monotonic() + 1.0
        with suppress(OSError):  # the console has left
            while select.select([self.fd], [], [], 0.03)[0]:
                self.screen.feed(os.read(self.fd, 65536))
                if time.monotonic() > give_up_s:
                    return False
        return True

    def _untrue(self, now_s: float) -> list[str]:
        """Every claim on the screen that the bay's log contradicts."""
        text, lately = self.text, {drove for _, drove in self._drove}
        header = text.split("\n", 1)[0]
        if "RECORDING" in header or not re.match(r" \S [A-Z]", header):
            return []
        said, sent = " ".join(text.split()), set(wheels_sent(text))
        since_s = min(filter(None, (self.cable.pulled_s, self.bay.frozen_s)), default=None)
        silent_s = now_s - since_s if since_s is not None else 0.0
        claims = {
            "says that it is stopped": ("STOPPED" in header, False in lately),
            "says that a state drives": (bool(re.search(r"● \w+ +Driving", text)), True in lately),
            "says that wheels are driven": (bool(sent - {"0 %"}), True in lately),
            "says that no wheel is driven": (sent == {"0 %"}, False in lately),
            "says that zero is sent": ("sent: 0" in text, False in lately),
            "says that wheels stood": ("its wheels stood" in said, False in lately),
            "says that the switch has stopped": (
                "switch has stopped the wheels" in said,
                not self.bay.drives or self.bay.frozen_s is not None,
            ),
            "shows a silent robot as live": (
                silent_s > KNOWN_S and self.live(text, header),
                False,
            ),
        }
        return [name for name, (claimed, so) in claims.items() if claimed and not so]

    def live(self, text: str, header: str) -> bool:
        """Whether anything on the screen is shown as what is so now."""
        speed = re.search(r"speed +(\S)", text)
        known = bool(re.search(r"^.*● \w+ +[A-Z]", text, re.MULTILINE))
        over = header.startswith(" ■") and "STOPPED," not in header
        return known or (speed is not None and speed[1].isdigit()) or not (header[1] == "?" or over)

    def end(self, sign: int = signal.SIGTERM, within_s: float = 20.0) -> int:
        """End the console; return its exit code."""
        os.kill(self.pid, sign)
        give_up_s = time.monotonic() + within_s
        while True:
            with suppress(OSError):
                if select.select([self.fd], [], [], 0.05)[0]:
                    self.screen.feed(os.read(self.fd, 65536))
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                os.close(self.fd)
                self.pid = -1
                return os.waitstatus_to_exitcode(status)
            assert time.monotonic() < give_up_s, "the console does not end"


def wheels_sent(text: str) -> list[str]:
    """What the page of the motors says was sent to each wheel."""
    return re.findall(r"^ *wheel_\d+ +(-?\d+ %)", text, re.MULTILINE)
