"""What the driver needs to know of one robot, worked out of its profile once."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, radians
from typing import NamedTuple

from pirate_sm.backends.pico.conversation import Wanted
from pirate_sm.backends.pico.framing import LONGEST_PAYLOAD
from pirate_sm.backends.pico.link import WireSlot
from pirate_sm.backends.pico.messages import Messages
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.errors import UsageError
from pirate_sm.model.profile import Profile, Slot
from pirate_sm.model.wire import Serial

SETPOINTS, ECHO, STATE = range(3)
"""Places of the wanted topics."""


class Plan(NamedTuple):
    """One robot on its wire.

    Attributes:
        channels: How many channels each board has that is listened to.
        modules: What people call these boards.
        safe_zero: Slots that are zero in the safe state.
        silent_after_s: A board that has not been heard for this long is silent.
    """

    serial: Serial
    messages: Messages
    wanted: tuple[Wanted, ...]
    slots: tuple[WireSlot, ...]
    channels: Mapping[int, int]
    modules: Mapping[int, str]
    safe_zero: tuple[int, ...]
    silent_after_s: float

    @property
    def away_s(self) -> float:
        """After its last sign of life the link may be away for this long."""
        return self.serial.boot + self.serial.recover_within


def plan_of(profile: Profile, robot: RobotSpec, messages: Messages) -> Plan:
    """The plan for this robot.

    Raises:
        UsageError: The robot has no serial link, or its messages cannot carry its setpoints.
    """
    serial = serial_of(profile)
    slots = tuple(_wire_slot(profile, slot) for slot in profile.slots)
    codec = messages.setpoints
    for slot in slots:
        if not codec.least <= round(-slot.limit / slot.resolution) or (
            round(slot.limit / slot.resolution) > codec.most
        ):
            raise UsageError(f"{codec.type.name}.msg: its integers are too small for {slot.name}")
    heard = profile.heard
    return Plan(
        serial=serial,
        messages=messages,
        wanted=_wanted(serial, messages, bool(heard)),
        slots=slots,
        channels={board.id: len(board.channels) for board in heard},
        modules={board.id: board.module for board in heard},
        safe_zero=robot.safe_zero,
        silent_after_s=profile.link.silent_after,
    )


def serial_of(profile: Profile) -> Serial:
    """How the robot speaks over its port.

    Raises:
        UsageError: It does not.
    """
    if profile.serial is None:
        raise UsageError(f"the robot {profile.robot} has no section 'serial' in its profile")
    return profile.serial


def _wanted(serial: Serial, messages: Messages, reports: bool) -> tuple[Wanted, ...]:
    """The topics that are needed; ``reports``: the device sends states by itself."""
    named = (
        (serial.setpoints.topic, messages.setpoints.type, "takes"),
        (serial.echo.topic, messages.echo.type, "publishes"),
        (serial.state.topic, messages.state.type, "publishes"),
    )
    return tuple(
        Wanted(
            topic, kind.name, kind.md5, "takes" if way == "takes" else "publishes", kind.text,
            LONGEST_PAYLOAD if kind.largest is None else kind.largest,
            answers=reports and topic == serial.echo.topic,
        )
        for topic, kind, way in named
    )  # fmt: skip


def _wire_slot(profile: Profile, slot: Slot) -> WireSlot:
    if slot.unit == "duty":
        return WireSlot(slot.name, profile.link.duty_resolution, 1.0)
    limit = inf if slot.limit is None else slot.limit
    return WireSlot(slot.name, profile.link.angle_resolution, min(limit, radians(360)))
