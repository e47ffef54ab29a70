"""The processes of a mission in real time over a pseudo-terminal, for whoever judges it."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

MISSION = "mitre_bend"

_GUARDIAN = b"pirate_sm.robot.backends.serial.guardian.process"
_RUNNER = "from pirate_sm.cli.entry import run_main; run_main()"
_DOCTOR = "from pirate_sm.cli.entry import main; main()"
_LOOK_EVERY_S = 0.02


class Port(NamedTuple):
    """The name of a bay's port, and the files beside it.

    Attributes:
        link: What the port is called.
    """

    link: Path

    @property
    def out(self) -> Path:
        """What the runner has written to standard output."""
        return self.link.with_suffix(".out")

    @property
    def err(self) -> Path:
        """What the runner has written to standard error."""
        return self.link.with_suffix(".err")


def start_bay(port: Port, *options: str) -> subprocess.Popen[str]:
    """Start a bay that writes down its truth, and wait until its port is there."""
    bay = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.witness", MISSION, str(port.link), *options],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert bay.stdout is not None
    bay.stdout.readline()
    return bay


def start_runner(port: Port) -> subprocess.Popen[bytes]:
    """Start the mission on this port, in a process group of its own."""
    arguments = (
        *(MISSION, "--backend", "serial", "--port", str(port.link), "--yes", "--json"),
        *("--record", str(port.link.with_suffix(".mcap"))),
    )
    with port.out.open("wb") as lines, port.err.open("wb") as errors:
        return subprocess.Popen(
            [sys.executable, "-c", _RUNNER, *arguments],
            stdin=subprocess.DEVNULL, stdout=lines, stderr=errors, start_new_session=True,
            preexec_fn=_heed,  # noqa: PLW1509 - no thread of ours holds a lock here
        )  # fmt: skip


def connect_again(port: Port) -> str:
    """Return why a second program cannot connect to the robot; empty where it can."""
    doctor = [sys.executable, "-c", _DOCTOR, "doctor", "--port", str(port.link), "--seconds", "1"]
    done = subprocess.run(doctor, capture_output=True, text=True, check=False)
    return "" if done.returncode in {0, 1} else done.stderr.strip()


def guardians(port: Port) -> list[int]:
    """Return the guardians of this port that live."""
    return [
        int(path.parent.name)
        for path in Path("/proc").glob("[0-9]*/cmdline")
        if {_GUARDIAN, bytes(port.link)} <= set(_read(path).split(b"\0"))
    ]


def wait_until(true: Callable[[], bool], patience_s: float) -> bool:
    """Return whether it became true in time."""
    give_up_s = time.monotonic() + patience_s
    while not true():
        if time.monotonic() > give_up_s:
            return False
        time.sleep(_LOOK_EVERY_S)
    return True


def _heed() -> None:
    """Ctrl-C and hang-ups are heard, also where this program was started in the background."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""
