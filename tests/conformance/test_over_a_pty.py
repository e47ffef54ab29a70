"""The same suite in real time: guardian and bay are processes, a pseudo-terminal is between them.

Three of its tests say what only time that is made up can keep: that equal seeds give equal events,
and that time neither goes on while nobody asks nor passes at once. They stay in virtual time.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from pirate_sm.core.loading import load_robot
from pirate_sm.robot.backends.protocol import Backend
from pirate_sm.robot.backends.serial.assembly import read_plan, serial_backend
from pirate_sm.testing import BackendContract, Candidate

from .candidates import NEWT, candidate

pytestmark = pytest.mark.slow

BAY = "from pirate_sm.cli.entry import main; main()"
Make = Callable[[int], Backend]


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    """Backends on bays of their own, which end with the test."""
    robot = load_robot(NEWT)
    plan = read_plan(NEWT, robot.profile, robot.normal)
    with ExitStack() as stack:

        def started(seed: int) -> Backend:
            link = tmp_path / f"bay{len(list(tmp_path.iterdir()))}"
            command = [
                *(sys.executable, "-u", "-c", BAY, "bay", "--robot", str(NEWT)),
                *("--pipe", str(NEWT / "elbow.yaml"), "--seed", str(seed), "--link", str(link)),
            ]
            bay = stack.enter_context(
                subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
            )
            stack.callback(bay.terminate)
            assert bay.stdout is not None
            assert bay.stdout.readline().startswith(b"/dev/")
            backend = serial_backend(plan, str(link), None)
            stack.callback(backend.close)
            return backend

        yield started


class TestOverAPty(BackendContract):
    # Only time that is made up stands still while nobody asks, and passes in no time.
    test_time_neither_goes_back_nor_past_what_was_asked = None  # type: ignore[assignment]
    test_a_limit_in_the_past_changes_nothing = None  # type: ignore[assignment]
    test_equal_seeds_give_equal_events = None  # type: ignore[assignment]

    @pytest.fixture
    def candidate(self, make: Make) -> Candidate:
        return candidate(make)
