"""The binary in real time behind a pseudo-terminal, with programs of their own at the other end."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.core.loading import load_pipe
from pirate_sm.simulation.bay.terminal import Terminal, serve

from .avr_bay import AvrBay, Built
from .test_tables import SIX_WHEELED, of

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

PIRATE = "from pirate_sm.cli.start import main; main()"


@pytest.fixture
def port(six_wheeled: Built, tmp_path: Path) -> Iterator[Path]:
    """A port with the binary behind it."""
    profile, plan = of(SIX_WHEELED)
    pipe, _ = load_pipe(SIX_WHEELED.parents[1] / "sequences" / "pipes" / "straight_113.yaml")
    bay, link, stop = AvrBay(six_wheeled, profile, SIX_WHEELED, pipe), tmp_path / "bay", []
    with Terminal(link, plan.serial.baud) as terminal:
        # `serve` asks only what every bay has.
        server = threading.Thread(target=serve, args=(bay, terminal, lambda: bool(stop)))
        server.start()
        yield link
        stop.append(True)
        server.join()


def test_pirate_doctor_says_go_and_names_the_firmware(port: Path) -> None:
    command = [sys.executable, "-c", PIRATE, "doctor", "--port", str(port), "--plain"]
    command += ["--robot", str(SIX_WHEELED), "--seconds", "3"]

    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=90)

    assert done.returncode == 0, done.stdout + done.stderr
    assert "firmware 1 of robot pirate_ii, tables " in done.stdout
