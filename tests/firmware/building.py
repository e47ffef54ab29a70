"""Builds the firmware and its tools by `firmware/Makefile`, where their compilers are."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).parents[2] / "firmware"


def made(
    target: str, build: Path, robot: Path = FIRMWARE / "robot.h", frames: int = 1_000_000
) -> str:
    """Make a target in this folder for this robot; return what make said.

    ``frames`` damaged frames are tried.

    A test is skipped where there is no compiler for it, and says so.
    """
    compiler = "avr-g++" if target == "all" else "g++"
    if shutil.which(compiler) is None:
        pytest.skip(f"there is no {compiler} here: the firmware is not built")
    header = Path("/usr/include/simavr/sim_avr.h")
    if target == "host" and not header.exists():
        pytest.skip("there is no libsimavr-dev here: what is flashed is not run")
    command = ["make", "--silent", target, f"BUILD={build}", f"ROBOT={robot}"]
    command.append(f"FRAMES={frames}")
    done = subprocess.run(command, cwd=FIRMWARE, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
