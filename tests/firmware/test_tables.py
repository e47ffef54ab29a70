"""The firmware's tables are those of the robot's files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pirate_sm.cli.entry import commands
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Profile
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.firmware_tables import firmware_header, tables_of
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from tests.conformance.candidates import NEWT

from .building import FIRMWARE

SIX_WHEELED = FIRMWARE.parent / "hardware_profiles" / "pirate_ii"


def of(folder: Path) -> tuple[Profile, LinkPlan]:
    robot = load_robot(folder)
    return robot.profile, read_plan(robot.folder, robot.profile, robot.normal)


def test_the_header_in_the_sketch_is_that_of_the_shipped_robot() -> None:
    """After a change of the robot: ``pirate firmware pirate_ii -o firmware/robot.h``."""
    assert (FIRMWARE / "robot.h").read_text(encoding="utf-8") == firmware_header(*of(SIX_WHEELED))


def test_another_robot_is_another_header() -> None:
    header = firmware_header(*of(NEWT))

    assert "constexpr uint8_t SLOTS = 7;" in header
    assert "constexpr bool STATE_ONE_VALUE = true;" in header
    assert "{40, 0, 2, 2}," in header
    assert "{3, 2, 3, 5}," in header
    assert "{17, 5, 2, 2}," in header
    assert "constexpr uint8_t ARRAY_HOLD_BYTES = 0;" in header
    assert "constexpr uint32_t HELD_WITHOUT_MASK = 0x16;" in header, "the lamp and both folds"


def test_a_robot_whose_firmware_has_no_switch_is_refused() -> None:
    profile, plan = of(SIX_WHEELED)
    serial = plan.serial.model_copy(update={"stop_after": None})

    with pytest.raises(UsageError, match="stop_after"):
        firmware_header(profile, plan._replace(serial=serial))


def test_an_echo_with_other_fields_than_the_array_is_refused() -> None:
    profile, plan = of(SIX_WHEELED)
    messages = plan.messages._replace(echo=of(NEWT)[1].messages.echo)

    with pytest.raises(UsageError, match=re.escape("Go.msg must have the fields of")):
        firmware_header(profile, plan._replace(messages=messages))


def test_what_is_told_changes_with_what_the_firmware_must_know_and_with_nothing_else() -> None:
    profile, plan = of(SIX_WHEELED)
    later = plan.serial.model_copy(update={"stop_after": 0.6})
    patient = plan.serial.model_copy(update={"recover_within": 9.0})

    assert tables_of(profile, plan._replace(serial=later)) != tables_of(profile, plan)
    assert tables_of(profile, plan._replace(serial=patient)) == tables_of(profile, plan)


def test_the_command_writes_the_header(tmp_path: Path) -> None:
    output = tmp_path / "robot.h"

    commands(["firmware", str(NEWT), "-o", str(output)], standalone_mode=False)

    assert output.read_text(encoding="utf-8") == firmware_header(*of(NEWT))
