"""The firmware's parts natively, and what it takes of the controller."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pirate_sm.cli.entry import commands
from pirate_sm.robot.backends.serial.firmware_tables import firmware_header
from tests.conformance.candidates import NEWT

from .building import FIRMWARE, made
from .test_tables import of

pytestmark = [pytest.mark.firmware, pytest.mark.timeout(600)]


def test_its_parts_do_what_they_should_and_a_million_damaged_frames_do_nothing(
    tmp_path: Path,
) -> None:
    assert "tests passed" in made("test", tmp_path)


def test_it_fits_into_the_controller(tmp_path: Path) -> None:
    assert "static memory" in made("all", tmp_path)


def test_the_page_leads_to_a_firmware_for_a_new_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = (FIRMWARE.parent / "docs" / "firmware.md").read_text(encoding="utf-8")
    commands(["new", "robot", "four"], standalone_mode=False)
    profile, messages = tmp_path / "four" / "profile.yaml", tmp_path / "four" / "messages"
    (section,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    messages.mkdir()
    for name, text in re.findall(r"`four/messages/(\S+)`.*?```text\n(.*?)```", page, re.DOTALL):
        (messages / name).write_text(text, encoding="utf-8")
    profile.write_text(f"{profile.read_text(encoding='utf-8')}\n{section}", encoding="utf-8")

    commands(["firmware", "four", "-o", "robot.h"], standalone_mode=False)

    assert "static memory" in made("all", tmp_path / "build", tmp_path / "robot.h")


def test_another_robot_needs_another_header_only(tmp_path: Path) -> None:
    header = tmp_path / "newt.h"
    header.write_text(firmware_header(*of(NEWT)), encoding="utf-8")

    assert "static memory" in made("all", tmp_path / "build", header)
