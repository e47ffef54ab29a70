"""What the driver needs to know of one robot, worked out of its profile once."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, radians
from typing import NamedTuple

from pirate_sm.backends.pico.conversation import Wanted
from pirate_sm.backends.pico.framing import LONGEST_PAYLOAD
from pirate_sm.backends.pico.link import WireSlot
from pirate_sm.backends.pico.messages import Messages
from pirate_sm.backends.pico.supervision import Watched
from pirate_sm.engine.robot import RobotSpec
from pirate_sm.errors import UsageError
from pirate_sm.model.profile import Board, Channel, Profile, Slot
from pirate_sm.model.wire import Serial

SETPOINTS, ECHO, STATE = range(3)
"""Places of the wanted topics."""

_FASTER = 3.0
"""A joint may turn so much faster than its motor without load: it may be pushed."""

_SLACK_RAD = radians(6)
_BEYOND_RAD = radians(12)
_STRONGER = 2.0
"""A motor's current may be so much larger than when it is stalled."""

_WOUND = 8.0
"""A spring behind a worm is wound up by others beyond what its own motor could do."""

_JOINT_MOVED_RAD = radians(20)
_WHEEL_MOVED_RAD = 1.0
_LEAST_DUTY = 1.5
"""Times the duty at which a motor begins to turn."""


class Plan(NamedTuple):
    """One robot on its wire.

    Attributes:
        channels: How many channels each board has that is listened to.
        modules: What people call these boards.
        safe_zero: Slots that are zero in the safe state.
        wheels: Slots that drive wheels.
        silent_after_s: A board that has not been heard for so long is silent.
        frame_s: The least time between two reports of one board; what comes at shorter intervals
            has waited somewhere.
    """

    serial: Serial
    messages: Messages
    wanted: tuple[Wanted, ...]
    slots: tuple[WireSlot, ...]
    channels: Mapping[int, int]
    modules: Mapping[int, str]
    watched: Mapping[int, tuple[Watched, ...]]
    safe_zero: tuple[int, ...]
    wheels: tuple[int, ...]
    silent_after_s: float
    frame_s: float

    @property
    def away_s(self) -> float:
        """After its last sign of life the link may be away for so long."""
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
    heard = [board for board in profile.boards if board.fitted and board.channels_fitted]
    heard = [board for board in heard if board.channels]
    return Plan(
        serial=serial,
        messages=messages,
        wanted=_wanted(serial, messages, bool(heard)),
        slots=slots,
        channels={board.id: len(board.channels) for board in heard},
        modules={board.id: board.module for board in heard},
        watched={board.id: _watched(profile, robot, board) for board in heard},
        safe_zero=robot.safe_zero,
        wheels=tuple(at for at, slot in enumerate(profile.slots) if slot.wheel is not None),
        silent_after_s=profile.link.silent_after,
        frame_s=profile.link.cycle * len(heard),  # one board a cycle (thesis section 4-2)
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


def _watched(profile: Profile, robot: RobotSpec, board: Board) -> tuple[Watched, ...]:
    spec = robot.boards.get(board.id)
    if spec is None:
        return ()
    scales = {place: scale for place, _, scale in spec.channels}
    zeros = dict(spec.zeros)
    shifts = {place: zeros.get(target, 0.0) / scale for place, target, scale in spec.channels}
    watched = [
        _watch(profile, board, place, scales)
        for place in sorted(scales)
        if board.channels[place].slot is not None
    ]
    return tuple(
        each._replace(low=each.low + shifts[each.place], high=each.high + shifts[each.place])
        for each in watched
    )


def _watch(profile: Profile, board: Board, place: int, scales: Mapping[int, float]) -> Watched:
    """What a channel may say; ``scales`` are SI per count by place."""
    channel, scale = board.channels[place], abs(scales[place])
    index = next(at for at, slot in enumerate(profile.slots) if slot.name == channel.slot)
    slot = profile.slots[index]
    motor = profile.motors[slot.motor]
    name = channel.signal or f"{channel.name} of board {board.id}"
    watched = Watched(place, name, slot=index)
    if channel.senses == "angle":
        return _watch_angle(profile, board, watched, slot, scales)
    if channel.senses == "torque" and motor.stall_torque is not None:
        most = _WOUND * motor.stall_torque / scale
        return watched._replace(low=-most, high=most)
    if channel.senses == "current" and motor.stall_current is not None:
        most = _STRONGER * motor.stall_current / scale
        return watched._replace(low=-most, high=most)
    return watched


def _watch_angle(
    profile: Profile, board: Board, watched: Watched, slot: Slot, scales: Mapping[int, float]
) -> Watched:
    motor, scale = profile.motors[slot.motor], abs(scales[watched.place])
    if motor.no_load_speed is not None:
        rate = _FASTER * motor.no_load_speed / scale
        watched = watched._replace(rate=rate, slack=_SLACK_RAD / scale)
    if slot.wheel is not None:
        # A wheel may slide along with a falling robot: that must be seen at once.
        return watched._replace(
            wheel=True, slack=_WHEEL_MOVED_RAD / scale, moved=_WHEEL_MOVED_RAD / scale
        )
    stop = next((j.end_stop for j in profile.body.joints if j.name == slot.joint), None)
    if stop is None:
        return watched
    most = (stop + _BEYOND_RAD) / scale
    watched = watched._replace(low=-most, high=most, joint=True, moved=_JOINT_MOVED_RAD / scale)
    load = _load(board.channels, slot)
    loop, full = motor.position_loop, motor.stall_current
    if load not in scales or loop is None or full is None:
        return watched
    full_load, least_duty = full / abs(scales[load]), _LEAST_DUTY * loop.least_duty
    return watched._replace(load=load, full_load=full_load, least_duty=least_duty)


def _load(channels: tuple[Channel, ...], slot: Slot) -> int:
    """Place of the current of the slot's motor; -1 where it is not measured."""
    for place, channel in enumerate(channels):
        if channel.senses == "current" and channel.slot == slot.name:
            return place
    return -1
