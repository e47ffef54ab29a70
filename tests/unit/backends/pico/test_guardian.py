"""The guardian as a process, with a pseudo-terminal for its port."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import time
import tty
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from pirate_sm.backends.pico.framing import Decoder, encode
from pirate_sm.backends.pico.guarded_port import GuardedPort
from pirate_sm.backends.pico.port import PortLostError
from pirate_sm.errors import BackendError

SAFE = encode(100, b"safe")
DRIVE = encode(100, b"drive")
PATIENCE_S = 10.0

RUNNER = """
import sys, time
from pirate_sm.backends.pico.guarded_port import GuardedPort
port = GuardedPort(sys.argv[1], 57600, 0.3)
port.open()
port.beat(bytes.fromhex(sys.argv[2]))
port.write(bytes.fromhex(sys.argv[3]))
print(port.guardian_pid, flush=True)
while True:
    port.beat(bytes.fromhex(sys.argv[2]))
    port.read(port.now() + 0.05)
    if port.overruled():
        print("overruled", flush=True)
"""


class Bench:
    """The device's end of a pseudo-terminal."""

    def __init__(self) -> None:
        self.ours, theirs = pty.openpty()
        tty.setraw(theirs)
        self.name = os.ttyname(theirs)
        self.theirs = theirs
        self.decoder = Decoder()
        self.frames: list[tuple[float, bytes]] = []

    def hear(self, payload: bytes) -> float:
        """When a frame with this payload came."""
        give_up_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < give_up_s:
            for at_s, heard in self.frames:
                if heard == payload:
                    return at_s
            if select.select([self.ours], [], [], 0.1)[0]:
                for frame in self.decoder.feed(os.read(self.ours, 4096)):
                    self.frames.append((time.monotonic(), frame.payload))
        raise AssertionError(f"{payload!r} never came, only {self.frames}")

    def close(self) -> None:
        for descriptor in (self.ours, self.theirs):
            with suppress(OSError):
                os.close(descriptor)


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.close()


@pytest.fixture
def runner(bench: Bench) -> Iterator[subprocess.Popen[str]]:
    arguments = [sys.executable, "-c", RUNNER, bench.name, SAFE.hex(), DRIVE.hex()]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as process:
        yield process
        process.kill()


def _gone(pid: int) -> bool:
    give_up_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < give_up_s:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            return True
        if state == "Z":
            return True
        select.select([], [], [], 0.02)
    return False


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP, signal.SIGTERM])
def test_however_the_runner_ends_the_safe_frame_follows_within_half_a_second(
    bench: Bench, runner: subprocess.Popen[str], how: signal.Signals
) -> None:
    assert runner.stdout is not None
    guardian = int(runner.stdout.readline())
    bench.hear(b"drive")
    ended_s = time.monotonic()
    runner.send_signal(how)

    assert bench.hear(b"safe") - ended_s < 0.5
    os.write(bench.ours, encode(126, b"safe"))
    runner.kill()
    runner.wait()
    assert _gone(guardian)


def test_a_runner_that_stood_still_is_told_however_much_the_device_has_said_meanwhile(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    assert runner.stdout is not None
    runner.stdout.readline()
    bench.hear(b"drive")
    runner.send_signal(signal.SIGSTOP)
    for _ in range(200):
        os.write(bench.ours, bytes(2000))  # more than the pipe between the two holds
    bench.hear(b"safe")
    os.write(bench.ours, encode(126, b"safe"))
    runner.send_signal(signal.SIGCONT)

    assert runner.stdout.readline() == "overruled\n"
    assert runner.poll() is None


def test_the_terminals_interrupt_does_not_reach_the_guardian_and_a_termination_ends_safely(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    assert runner.stdout is not None
    guardian = int(runner.stdout.readline())
    bench.hear(b"drive")
    os.kill(guardian, signal.SIGINT)
    os.kill(guardian, signal.SIGHUP)
    os.write(bench.ours, b"alive")
    os.kill(guardian, signal.SIGTERM)

    bench.hear(b"safe")
    os.write(bench.ours, encode(126, b"safe"))
    assert _gone(guardian)


def test_it_relays_and_leaves_quietly(bench: Bench) -> None:
    port = GuardedPort(bench.name, 57600, 5.0)
    port.open()
    port.beat(SAFE)
    port.write(DRIVE)
    bench.hear(b"drive")
    os.write(bench.ours, b"hello")
    assert port.read(port.now() + PATIENCE_S) == b"hello"
    guardian = port.guardian_pid
    port.close()

    assert guardian is not None
    assert _gone(guardian)
    assert [payload for _, payload in bench.frames] == [b"drive"]


def test_a_port_is_for_one_program_only(bench: Bench) -> None:
    first = GuardedPort(bench.name, 57600, 5.0)
    first.open()

    with pytest.raises(BackendError, match="in use by another program"):
        GuardedPort(bench.name, 57600, 5.0).open()
    first.close()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("/dev/ttyNotThere", "there is no port /dev/ttyNotThere; there "),
        ("/dev/null", "/dev/null is no serial port"),
        ("nonsense://x", "nonsense://x cannot be a serial port"),
    ],
)
def test_a_wrong_port_is_told_as_what_it_is(name: str, message: str) -> None:
    with pytest.raises(BackendError, match=message):
        GuardedPort(name, 57600, 5.0).open()


def test_a_port_that_goes_away_is_lost(bench: Bench) -> None:
    port = GuardedPort(bench.name, 57600, 5.0)
    port.open()
    bench.close()

    with pytest.raises(PortLostError, match="has gone"):
        port.read(port.now() + PATIENCE_S)
    port.close()


def test_a_guardian_that_dies_is_a_lost_port_and_the_next_one_takes_over(bench: Bench) -> None:
    port = GuardedPort(bench.name, 57600, 5.0)
    port.open()
    assert port.guardian_pid is not None
    os.kill(port.guardian_pid, signal.SIGKILL)
    with pytest.raises(PortLostError, match="guardian of the port has died"):
        port.read(port.now() + PATIENCE_S)

    assert port.reopen()
    port.write(DRIVE)
    bench.hear(b"drive")
    port.close()
