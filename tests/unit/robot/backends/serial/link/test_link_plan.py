"""What a robot's messages must be able to carry."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_robot
from pirate_sm.robot.backends.serial.link.link_plan import plan_of
from pirate_sm.robot.rosserial.messages import read_messages, serial_of

from ..conftest import SIX_WHEELED


@pytest.mark.parametrize("limited", [True, False])
def test_setpoints_are_written_in_their_resolution_and_within_their_limit(limited: bool) -> None:
    """An angle without a limit of its own turns once round at most."""
    robot = load_robot(SIX_WHEELED)
    serial, link = serial_of(robot.profile), robot.profile.link
    messages = read_messages(SIX_WHEELED / serial.messages, serial, len(robot.profile.slots))
    boards = tuple(
        board.model_copy(
            update={
                "slots": tuple(
                    slot if limited else slot.model_copy(update={"limit": None})
                    for slot in board.slots
                )
            }
        )
        for board in robot.profile.boards
    )
    profile = robot.profile.model_copy(update={"boards": boards})

    written = plan_of(profile, robot.normal, messages).slots

    for slot, wire in zip(profile.slots, written, strict=True):
        duty, turn = (link.duty_resolution, 1.0), (link.angle_resolution, slot.limit or math.tau)
        assert (wire.name, wire[1:]) == (slot.name, duty if slot.unit == "duty" else turn)
    assert {slot.unit for slot in profile.slots} == {"duty", "angle"}


def test_integers_that_do_not_reach_the_limit_of_a_slot_are_refused(tmp_path: Path) -> None:
    robot = load_robot(SIX_WHEELED)
    serial = serial_of(robot.profile)
    for text in (SIX_WHEELED / serial.messages).glob("*.msg"):
        small = text.read_text(encoding="utf-8").replace("int16[18]", "int8[18]")
        (tmp_path / text.name).write_text(small, encoding="utf-8")
    messages = read_messages(tmp_path, serial, len(robot.profile.slots))

    with pytest.raises(UsageError, match="its integers are too small for camera_tilt"):
        plan_of(robot.profile, robot.normal, messages)
