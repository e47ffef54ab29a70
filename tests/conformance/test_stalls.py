"""A runner that the computer stops for a moment finishes its mission: a pause is not a fall.

In real time: runner, guardian and bay are processes, a pseudo-terminal is between them. The
runner alone is stopped, for longer than the boards need to report and more briefly than its
guardian has patience.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
PYTHON = (sys.executable, "-u", "-c", "from pirate_sm.cli.entry import main; main()")
DRIVES = 10
STOPS = 6

MISSION = """
format: 1
mission: drive
robot: pirate_ii
pipe: {diameter: 120 mm, segments: [{straight: 3 m}], start: {at: 500 mm}}
start: drive
phases:
  drive:
    do: [ClampFront, ClampRear, DriveForward]
    wait: [{when: odometry >= 0.5 m, go: there}]
    within: {time: 40 s, go: late}
ends:
  there: {succeed: There}
  late: {fail: Too late}
"""


@pytest.fixture
def port(tmp_path: Path) -> Iterator[Path]:
    """The pseudo-terminal of an emulated bay."""
    link = tmp_path / "port"
    (tmp_path / "drive.yaml").write_text(MISSION, encoding="utf-8")
    command = (*PYTHON, "bay", "--mission", str(tmp_path / "drive.yaml"), "--link", str(link))
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=ROOT
    ) as bay:
        assert bay.stdout is not None
        assert bay.stdout.readline().startswith(b"/dev/")
        yield link
        bay.terminate()


@pytest.mark.parametrize("drive", range(DRIVES))
def test_a_runner_that_is_stopped_for_a_moment_succeeds(port: Path, drive: int) -> None:
    chance = random.Random(drive)
    mission = str(port.with_name("drive.yaml"))
    options = ("--backend", "serial", "--port", str(port), "--json", "--no-record", "--yes")
    with subprocess.Popen(
        (*PYTHON, "run", mission, *options),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        cwd=ROOT,
        text=True,
    ) as runner:
        assert runner.stdout is not None
        told = []
        for line in runner.stdout:
            told.append(line)
            if "DriveForward" in line and '"done"' in line:
                break
        for _ in range(STOPS):
            time.sleep(chance.uniform(0.2, 0.5))
            os.kill(runner.pid, signal.SIGSTOP)
            time.sleep(chance.uniform(0.05, 0.25))
            os.kill(runner.pid, signal.SIGCONT)
        stopped_while_driving = runner.poll() is None
        told += runner.stdout

    assert stopped_while_driving, told[-1]
    assert runner.returncode == 0, "".join(told)[-3000:]
