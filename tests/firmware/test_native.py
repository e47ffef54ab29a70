"""The firmware's parts natively, and what it takes of the controller."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.robot.backends.serial.firmware_tables import firmware_header
from tests.conformance.candidates import NEWT

from .building import made
from .test_tables import of

pytestmark = [pytest.mark.firmware, pytest.mark.timeout(600)]


def test_its_parts_do_what_they_should_and_a_million_damaged_frames_do_nothing(
    tmp_path: Path,
) -> None:
    assert "tests passed" in made("test", tmp_path)


def test_it_fits_into_the_controller(tmp_path: Path) -> None:
    assert "static memory" in made("all", tmp_path)


def test_another_robot_needs_another_header_only(tmp_path: Path) -> None:
    header = tmp_path / "newt.h"
    header.write_text(firmware_header(*of(NEWT)), encoding="utf-8")

    assert "static memory" in made("all", tmp_path / "build", header)
