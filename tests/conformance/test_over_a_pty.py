"""The same suite in real time: guardian and bay are processes, a pseudo-terminal is between them.

Two of its tests say what only time that is made up can keep: that equal seeds give equal events,
and that time does not go on while nobody asks. They stay in virtual time.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from pirate_sm.backends.protocol import Backend
from pirate_sm.backends.serial.assembly import read_plan, serial_backend
from pirate_sm.loading.robot import load_robot

from .candidates import NEWT, Candidate
from .test_backends import (  # noqa: F401 - collected here with the fixtures of this module
    test_a_closed_one_takes_nothing_more_and_can_be_closed_again,
    test_a_mission_runs_on_it_to_its_end,
    test_a_result_comes_even_if_one_asks_without_a_limit,
    test_an_array_meets_exactly_one_fate,
    test_arrays_in_quick_succession_meet_one_fate_each_and_the_last_is_not_superseded,
    test_it_may_be_closed_at_any_time_and_more_than_once,
    test_it_says_what_it_is,
    test_nothing_moves_before_the_first_array,
    test_the_same_array_may_be_submitted_again,
)

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


@pytest.fixture
def candidate(make: Make) -> Candidate:
    return Candidate(make)


@pytest.fixture
def backend(candidate: Candidate) -> Backend:
    return candidate.make(0)
