"""What a robot's messages must be able to carry."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.backends.serial.link.link_plan import plan_of
from pirate_sm.errors import UsageError
from pirate_sm.loading.robot import load_robot
from pirate_sm.rosserial.messages import read_messages, serial_of

from ..conftest import SIX_WHEELED


def test_integers_that_do_not_reach_the_limit_of_a_slot_are_refused(tmp_path: Path) -> None:
    robot = load_robot(SIX_WHEELED)
    serial = serial_of(robot.profile)
    for text in (SIX_WHEELED / serial.messages).glob("*.msg"):
        small = text.read_text(encoding="utf-8").replace("int16[18]", "int8[18]")
        (tmp_path / text.name).write_text(small, encoding="utf-8")
    messages = read_messages(tmp_path, serial, len(robot.profile.slots))

    with pytest.raises(UsageError, match="its integers are too small for camera_tilt"):
        plan_of(robot.profile, robot.normal, messages)
