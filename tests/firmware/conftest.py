"""The firmware of two robots, and the simulated controller, built once."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from pirate_sm.robot.backends.serial.firmware_tables import firmware_header
from tests.conformance.candidates import NEWT

from .avr_bay import Built
from .building import made
from .test_tables import SIX_WHEELED, of

Build = Callable[[Path], Built]


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """The firmware of the robot in a folder."""
    folder, ready = tmp_path_factory.mktemp("firmware"), dict[Path, Built]()

    def building(robot: Path) -> Built:
        if robot not in ready:
            own = folder / robot.name
            own.mkdir()
            (own / "robot.h").write_text(firmware_header(*of(robot)), encoding="utf-8")
            made("all", own / "out", own / "robot.h")
            made("host", folder)
            elf = own / "out" / "firmware.elf"
            ready[robot] = Built(folder / "host", elf, _end_of_memory(elf))
        return ready[robot]

    return building


def _end_of_memory(elf: Path) -> int:
    """Return the address behind what the firmware has in memory; the stack comes down to it."""
    names = subprocess.run(["avr-nm", elf], capture_output=True, text=True, check=True).stdout
    (line,) = (line for line in names.splitlines() if line.endswith(" _end"))
    return int(line.split()[0], 16) & 0xFFFF


@pytest.fixture(scope="session")
def six_wheeled(build: Build) -> Built:
    return build(SIX_WHEELED)


@pytest.fixture(scope="session")
def newt(build: Build) -> Built:
    return build(NEWT)
