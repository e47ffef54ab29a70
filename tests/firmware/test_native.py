"""The firmware's parts natively, and what it takes of the controller."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from pirate_sm.robot.backends.serial.firmware_tables import firmware_header
from tests.conformance.candidates import NEWT

from .building import FIRMWARE, made
from .test_tables import of

pytestmark = pytest.mark.timeout(600)


@pytest.mark.parametrize(
    "frames",
    [
        pytest.param(20_000, marks=pytest.mark.thorough),
        pytest.param(1_000_000, marks=pytest.mark.firmware),
    ],
)
def test_its_parts_do_what_they_should_also_if_frames_are_damaged(
    frames: int, tmp_path: Path
) -> None:
    said = made("test", tmp_path, frames=frames)

    assert f"{frames} of them damaged" in said
    assert "tests passed" in said


@pytest.mark.thorough
def test_it_fits_into_the_controller(tmp_path: Path) -> None:
    assert "static memory" in made("all", tmp_path)


@pytest.mark.thorough
def test_another_robot_needs_another_header_only(tmp_path: Path) -> None:
    header = tmp_path / "newt.h"
    header.write_text(firmware_header(*of(NEWT)), encoding="utf-8")

    assert "static memory" in made("all", tmp_path / "build", header)


@pytest.mark.thorough
def test_a_topic_with_a_name_that_fits_into_no_introduction_is_refused(tmp_path: Path) -> None:
    header = tmp_path / "robot.h"
    text = (FIRMWARE / "robot.h").read_text(encoding="utf-8")
    header.write_text(text.replace('"state"', f'"{"s" * 200}"'), encoding="utf-8")

    with pytest.raises(AssertionError, match="the name of a topic or of its type is too long"):
        made("all", tmp_path / "build", header)


@pytest.mark.parametrize("build", [".", "..", "src", "src/new"])
def test_sources_are_not_built_over(build: str) -> None:
    command = ["make", "--dry-run", "clean", f"BUILD={build}"]

    done = subprocess.run(command, cwd=FIRMWARE, capture_output=True, text=True, check=False)

    assert done.returncode != 0
    assert "choose another" in done.stderr
