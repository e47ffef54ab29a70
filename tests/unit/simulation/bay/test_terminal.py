"""The bay behind a pseudo-terminal: one short run with a real port and a real clock."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import termios
import threading
import time
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pirate_sm.cli.entry import commands
from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.robot.rosserial.frames import encode
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.firmware import Record
from pirate_sm.simulation.bay.terminal import Terminal, line_of, serve
from pirate_sm.simulation.bay.virtual import VirtualBay

from .conftest import SETPOINTS, array

PATIENCE_S = 10.0
LAST = 1000


@pytest.fixture
def served(
    profile: Profile, texts: dict[str, str], pipe: Pipe, tmp_path: Path
) -> Iterator[tuple[str, Path]]:
    """A link to a bay that boots quickly, and its log."""
    bay = VirtualBay(profile, pipe, texts, Switches(boot_s=0.05))
    link, log = tmp_path / "port", tmp_path / "log"
    stop = threading.Event()
    with Terminal(link, 57600) as terminal, log.open("w") as lines:
        thread = threading.Thread(target=serve, args=(bay, terminal, stop.is_set, lines))
        thread.start()
        yield str(link), log
        stop.set()
        thread.join(PATIENCE_S)
    assert not link.is_symlink()


def read_until(port: int, wanted: bytes, ask: bytes) -> bytes:
    """What came until it held what was wanted; asks every 200 ms."""
    deadline = time.monotonic() + PATIENCE_S
    ask_at = 0.0
    found = b""
    while wanted not in found and time.monotonic() < deadline:
        if time.monotonic() >= ask_at:
            ask_at = time.monotonic() + 0.2
            os.write(port, ask)
        if select.select([port], [], [], 0.05)[0]:
            found += os.read(port, 4096)
    assert wanted in found
    return found


def talk(path: str, number: int) -> None:
    """A host has come, sent one array, seen its echo, sent another one and gone at once."""
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        tty.setraw(port)
        read_until(port, b"bay ready", encode(0, b""))
        payload = array(number)
        read_until(port, encode(126, payload), encode(SETPOINTS, payload))
        os.write(port, encode(SETPOINTS, array(number + LAST)))
    finally:
        os.close(port)


def events(log: Path, until: int) -> list[tuple[str, int | None]]:
    """What has happened, once the array of this id is in force."""
    deadline = time.monotonic() + PATIENCE_S
    found: list[tuple[str, int | None]] = []
    while ("applied", until) not in found and time.monotonic() < deadline:
        time.sleep(0.01)
        lines = [json.loads(line) for line in log.read_text().splitlines()]
        found = [(line["event"], line.get("id")) for line in lines]
    return found


def test_hosts_come_and_go_and_what_they_sent_last_counts(served: tuple[str, Path]) -> None:
    path, log = served
    talk(path, 7)
    assert ("applied", 7) in events(log, 7 + LAST)
    talk(path, 8)
    found = events(log, 8 + LAST)

    visits = [event for event, _ in found if event in {"opened", "reset", "closed"}]
    assert visits == ["opened", "reset", "closed"] * 2
    assert {number for event, number in found if event == "applied"} == {7, 1007, 8, 1008}


def test_a_host_at_another_rate_reads_and_sends_garbage() -> None:
    with Terminal(baud=57600) as terminal:
        port = os.open(terminal.name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            heard = {}
            for name, speed in (("right", termios.B57600), ("wrong", termios.B9600)):
                settings = termios.tcgetattr(port)
                settings[4] = settings[5] = speed
                termios.tcsetattr(port, termios.TCSANOW, settings)
                os.write(port, b"to the bay")
                terminal.write(b"to the host")
                heard[name] = (terminal.wait(PATIENCE_S)[1], os.read(port, 100))
        finally:
            os.close(port)

    assert heard["right"] == (b"to the bay", b"to the host")
    assert heard["wrong"][0] != b"to the bay"
    assert heard["wrong"][1] != b"to the host"
    assert len(heard["wrong"][1]) == len(b"to the host")


def test_a_link_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(UsageError, match="no link can be made"):
        Terminal(tmp_path / "file")
    assert (tmp_path / "file").read_text() == "mine"


def test_a_link_that_a_killed_bay_has_left_is_replaced_and_no_other(tmp_path: Path) -> None:
    link, dead = tmp_path / "bay", tmp_path / "gone"
    link.symlink_to(dead)
    with Terminal(link) as first:
        assert str(link.readlink()) == first.name
        with pytest.raises(UsageError, match=f"it leads to {first.name}, which is in use"):
            Terminal(link)
        assert str(link.readlink()) == first.name
    assert not link.is_symlink()


def test_a_record_is_a_line_of_json() -> None:
    line = line_of(Record(1.5, "applied", 3, (1, -1)))

    assert json.loads(line) == {"at_s": 1.5, "event": "applied", "id": 3, "setpoints": [1, -1]}
    assert json.loads(line_of(Record(2.0, "closed"))) == {"at_s": 2.0, "event": "closed"}


@pytest.mark.thorough
def test_the_command_prints_its_port_first_and_ends_when_told(tmp_path: Path) -> None:
    code = "from pirate_sm.cli.entry import main; main()"
    log = tmp_path / "log"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "bay", "--loss", "20%", "--boot", "0.05", "--log", str(log)],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        name = process.stdout.readline().strip()
        port = os.open(name, os.O_RDWR | os.O_NOCTTY)
        read_until(port, b"bay ready", encode(0, b""))
        os.close(port)
        process.terminate()

        assert process.wait(PATIENCE_S) == 0
        assert json.loads(log.read_text().splitlines()[0])["event"] == "opened"
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--loss", "150%"], "loss_in is a share between 0 and 100%"),
        (["--wrong-md5", "stat"], "did you mean 'state'?"),
        (["--defect", "bay_silnt"], "did you mean 'bay_silent'?"),
        (["--robot", "nobody"], "nobody"),
    ],
)
def test_what_cannot_be_used_ends_it_with_2(arguments: list[str], says: str) -> None:
    done = CliRunner().invoke(commands, ["bay", *arguments])

    assert done.exit_code == 2
    assert says in done.stderr
    assert done.stdout == ""
