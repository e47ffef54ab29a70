"""What one robot makes of its link: topics, integers of its slots, the rate at which it reads."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from math import inf, isfinite, radians
from typing import NamedTuple

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Profile, Serial, Slot
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.backends.serial.link.conversation import Wanted
from pirate_sm.robot.rosserial.frames import LONGEST_PAYLOAD, Direction
from pirate_sm.robot.rosserial.message_types import MessageType
from pirate_sm.robot.rosserial.messages import Messages, serial_of

# --- slots ----------------------------------------------------------------------------------------


Integers = tuple[int, ...]

_ROUNDING = 1e-6


class WireSlot(NamedTuple):
    """How one setpoint is written, and its limit, checked here once more.

    Attributes:
        resolution: Value of one count.
        limit: Largest magnitude, in the slot's own unit.
    """

    name: str
    resolution: float
    limit: float


def why_refused(slots: Sequence[WireSlot], values: Sequence[float]) -> str:
    """Return why this array must not be sent; empty if it may (thesis section 4-2-1)."""
    if len(values) != len(slots):
        return f"{len(values)} values for {len(slots)} slots"
    for slot, value in zip(slots, values, strict=True):
        if not isfinite(value):
            return f"{slot.name} is no number"
        if abs(value) > slot.limit + _ROUNDING:
            return f"{slot.name} = {value:g} is beyond its limit of {slot.limit:g}"
    return ""


def to_counts(slots: Sequence[WireSlot], values: Sequence[float]) -> Integers:
    """Return the array as counts of the wire."""
    pairs = zip(slots, values, strict=True)
    return tuple(round(value / slot.resolution) for slot, value in pairs)


# --- the plan -------------------------------------------------------------------------------------


SETPOINTS, ECHO, STATE = range(3)
"""Indices of the wanted topics."""


class LinkPlan(NamedTuple):
    """What the driver needs to know of one robot.

    Attributes:
        channels: Number of channels of each board that reports.
        modules: What people call these boards.
        safe_zero: Slots that are zero in the safe state.
        silent_after_s: A board that has not reported for this long is silent.
        tables: What the firmware of this robot says of its tables, if it is ours; empty: unknown.
    """

    serial: Serial
    messages: Messages
    wanted: tuple[Wanted, ...]
    slots: tuple[WireSlot, ...]
    channels: Mapping[int, int]
    modules: Mapping[int, str]
    safe_zero: tuple[int, ...]
    silent_after_s: float
    tables: str = ""

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


# --- the rate of writing --------------------------------------------------------------------------


RING_BYTES = 64
"""Receive ring of the Arduino Mega's serial port."""

_READ_WITHIN_S = 0.020
"""A healthy device reads its ring this often; a frame must be complete by then too."""

_BITS_PER_BYTE = 10
"""Bits of a byte on the wire: start bit, eight data bits, stop bit."""

_SETPOINT_SHARE = 1 / 6
"""Share of the line for arrays of setpoints: 20 per second at 57,600 baud and 18 slots."""


class Throttle:
    """Keeps the bytes under way to the device below its ring, whatever the device does meanwhile.

    Args:
        baud: Baud rate of the line.
    """

    def __init__(self, baud: int) -> None:
        self._byte_s = _BITS_PER_BYTE / baud
        self._written: deque[tuple[float, int]] = deque()
        self._recent = 0

    def free_s(self, size: int, now: float) -> float:
        """Return when a frame of this size may be written; ``now`` if at once."""
        self._forget(now)
        excess = self._recent + min(size, RING_BYTES) - RING_BYTES
        free = now
        for at_s, written in self._written:
            if excess <= 0:
                break
            excess -= written
            free = at_s
        return free

    def wrote(self, size: int, now: float, busy_s: float = 0.0) -> None:
        """Count this many bytes as written.

        Args:
            size: Number of bytes.
            now: The time.
            busy_s: How long the device reads nothing after these bytes.
        """
        arrives = max(now, self._written[-1][0] - _READ_WITHIN_S if self._written else now)
        self._written.append((arrives + size * self._byte_s + _READ_WITHIN_S + busy_s, size))
        self._recent += size

    def spacing_s(self, size: int) -> float:
        """Return the least time between two arrays with frames of this size, s."""
        return size * self._byte_s / _SETPOINT_SHARE

    def _forget(self, now: float) -> None:
        while self._written and self._written[0][0] <= now:
            self._recent -= self._written.popleft()[1]
