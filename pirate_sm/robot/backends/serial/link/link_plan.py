"""The numbers of one robot that the driver needs, taken from its profile."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, radians
from typing import NamedTuple

from pirate_sm.core.errors import UsageError
from pirate_sm.core.profile import Profile, Serial, Slot
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.backends.serial.link.wanted_topics import Wanted
from pirate_sm.robot.backends.serial.link.wire_slots import WireSlot
from pirate_sm.robot.rosserial.frames import LONGEST_PAYLOAD
from pirate_sm.robot.rosserial.message_types import MessageType
from pirate_sm.robot.rosserial.messages import Messages, serial_of
from pirate_sm.robot.rosserial.topics import Direction

SETPOINTS, ECHO, STATE = range(3)
"""Indices of the wanted topics."""


class LinkPlan(NamedTuple):
    """What the driver needs to know of one robot.

    Attributes:
        channels: Number of channels of each board that reports.
        modules: What people call these boards.
        safe_zero: Slots that are zero in the safe state.
        silent_after_s: A board that has not reported for this long is silent.
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
        """How long after its last sign of life the link may be away, s."""
        return self.serial.boot + self.serial.recover_within


def plan_of(profile: Profile, robot: RobotSpec, messages: Messages) -> LinkPlan:
    """Return the plan for this robot.

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
    return LinkPlan(
        serial=serial,
        messages=messages,
        wanted=_wanted(serial, messages, bool(heard)),
        slots=slots,
        channels={board.id: len(board.channels) for board in heard},
        modules={board.id: board.module for board in heard},
        safe_zero=robot.safe_zero,
        silent_after_s=profile.link.silent_after,
    )


def _wanted(serial: Serial, messages: Messages, reports: bool) -> tuple[Wanted, ...]:
    """Return the required topics; ``reports``: the device sends states by itself."""

    def wanted(topic: str, kind: MessageType, way: Direction, answers: bool = False) -> Wanted:
        longest = LONGEST_PAYLOAD if kind.largest is None else kind.largest
        return Wanted(topic, kind.name, kind.md5, way, kind.text, longest, answers)

    return (
        wanted(serial.setpoints.topic, messages.setpoints.type, "takes"),
        wanted(serial.echo.topic, messages.echo.type, "publishes", answers=reports),
        wanted(serial.state.topic, messages.state.type, "publishes"),
    )


def _wire_slot(profile: Profile, slot: Slot) -> WireSlot:
    if slot.unit == "duty":
        return WireSlot(slot.name, profile.link.duty_resolution, 1.0)
    limit = inf if slot.limit is None else slot.limit
    return WireSlot(slot.name, profile.link.angle_resolution, min(limit, radians(360)))
