"""Decide which sensor values are plausible, and report faulty sensors.

Every value of a frame is compared with what the body and the motors can do. An impossible value is
held back for a few readings and replaced by the last believed value, because a spike is over by
then. A value that persists is believed if it can be true: the next reading continues in the same
direction (a trend), or the value is a counter, which may have restarted. The angle of a joint that
has jumped is not believed, because either of the two angles may be the wrong one. It is unknown
until it jumps back. A value outside its range and the value of a stuck sensor are unknown as well.

A joint behind a spring can snap faster than its motor turns. The spring then unwinds by the angle
that the joint has turned, and its torque, which another sensor measures, changes accordingly. Such
an angle is believed at once. Where that torque is measured, nothing else is faster than the motor.

Values are in SI units; unknown is NaN. The profile holds the thresholds, in ``plausibility``.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan

from pirate_sm.core._engine.sensing.motion_plausibility import (
    NOTHING_COMPARED,
    MotionRows,
    after_motion,
)
from pirate_sm.core._engine.sensing.plausibility_spec import (
    PlausibilitySpec,
    WatchedSpec,
    WatchSpec,
)
from pirate_sm.core._engine.sensing.sensor_memory import BoardMemory, Reading, SensorMemory
from pirate_sm.core._engine.sensing.value_plausibility import torque, weigh, weigh_jumped
from pirate_sm.core._model.events import FaultReport


def unseen(watched: WatchedSpec) -> BoardMemory:
    """Return the memory of a board that has not reported yet."""
    return BoardMemory((SensorMemory(),) * len(watched.sensors))


def start_again(record: BoardMemory) -> BoardMemory:
    """Return the memory after a restart of the firmware, when counters may start at zero.

    Joint angles survive a restart, so an implausible joint sensor stays implausible.
    """
    channels = tuple(
        channel
        if channel.jumped or not isnan(channel.stuck)
        else SensorMemory(hidden=channel.hidden)
        for channel in record.channels
    )
    return record._replace(channels=channels, seen=0)


def sift(
    spec: PlausibilitySpec,
    watched: WatchedSpec,
    record: BoardMemory,
    numbers: list[float],
    reading: Reading,
    motion: MotionRows = NOTHING_COMPARED,
) -> tuple[BoardMemory, list[FaultReport]]:
    """Replace implausible numbers, and report faulty sensors.

    Args:
        spec: Thresholds of the robot.
        watched: The board's sensors with limits.
        record: The memory of these sensors.
        numbers: All numbers, with those of this board as reported; modified in place.
        reading: The circumstances of the frame.
        motion: The comparison with what was asked of the motors.

    Returns:
        The new memory, and the new faults.
    """
    reports: list[FaultReport] = []
    shown, repeated = list(numbers), motion.repeated(numbers)
    channels: Sequence[SensorMemory] = [
        _believe(spec, watch, channel, record.seen, shown, reading, repeated.get(at), reports)
        for at, (watch, channel) in enumerate(zip(watched.sensors, record.channels, strict=True))
    ]
    channels, found = after_motion(spec, watched, channels, motion, numbers, reading.now_s)
    seen = record.seen if record.seen > spec.hold_back else record.seen + 1  # limited
    for watch, channel in zip(watched.sensors, channels, strict=True):
        value = numbers[watch.number]
        numbers[watch.number] = nan if channel.stuck == value else shown[watch.number]
    return _record(watched, channels, seen), [*reports, *found]


def _record(watched: WatchedSpec, channels: Sequence[SensorMemory], seen: int) -> BoardMemory:
    """Return the memory of a board with these sensors and its doubted numbers."""
    doubted = [
        watch.numbers
        for watch, channel in zip(watched.sensors, channels, strict=True)
        if channel.doubted
    ]
    special = any(not channel.calm for channel in channels)
    return BoardMemory(tuple(channels), seen, special, frozenset().union(*doubted))


def _believe(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: SensorMemory,
    seen: int,
    shown: list[float],
    reading: Reading,
    repeated: tuple[float, float] | None,
    reports: list[FaultReport],
) -> SensorMemory:
    """Return the sensor's memory after a reading, and write the shown value into ``shown``."""
    if channel.calm:
        good, good_s = reading.before[watch.number], reading.now_s - reading.elapsed_s
        if repeated and repeated[0] == good and repeated[1] < good_s:  # its board may repeat it
            good_s = max(repeated[1], good_s - spec.repeats_s)
        wound = torque(watch, reading.before)
        channel = channel._replace(good=good, good_s=good_s, seen=seen, wound=wound)
    value = shown[watch.number]
    if isnan(value):
        return channel._replace(calm=False, held=channel.held if channel.jumped else ())
    if value == channel.stuck:
        return channel
    judge = weigh_jumped if channel.jumped else weigh
    channel, shown[watch.number] = judge(spec, watch, channel, shown, reading, reports)
    return channel
