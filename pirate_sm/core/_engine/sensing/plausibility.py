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

from collections.abc import Callable, Sequence
from math import inf, isnan, nan
from operator import itemgetter
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.records import often_replaced
from pirate_sm.core._engine.sensing.board_spec import PlausibilitySpec, WatchedSpec, WatchSpec
from pirate_sm.core._engine.sensing.evaluator import JUST_MOVED
from pirate_sm.core._model.events import FaultReport

Numbers = Sequence[float]


# --- what is remembered of sensors ------------------------------------------------------------


class SensorMemory(NamedTuple):
    """The memory of one sensor; it does not change while its readings are normal.

    Attributes:
        calm: Whether the last reading was believed and none of ``good`` to ``jumped`` but
            ``since_s`` is in use.
        good: The last believed value; ``good_s``: its time; ``seen``: the readings until then.
        wound: The torque of the joint's spring at ``good_s``; NaN if it is unknown.
        held: The last readings since then that were not believed; the first and the last one of a
            joint that has jumped.
        since_s: When its values began to be believed again, after a jump or as a counter that has
            restarted. While it is not believed after a jump: since when its readings have followed
            one another, if that can restore belief; else infinite.
        running: Direction of a trend faster than the motor; 0 without one.
        outside: Whether it was reported as outside its range; ``jumped``: as having jumped.
        stuck: The value at which it is stuck; NaN if it is not.
        hidden: Number of spikes so far; ``spikes``: the times of the last ones.
        spiking_s: When it was last reported as spiking.
    """

    calm: bool = True
    good: float = nan
    good_s: float = -inf
    wound: float = nan
    seen: int = 0
    held: tuple[float, ...] = ()
    since_s: float = -inf
    running: float = 0.0
    outside: bool = False
    jumped: bool = False
    stuck: float = nan
    hidden: int = 0
    spikes: tuple[float, ...] = ()
    spiking_s: float = -inf

    @property
    def doubted(self) -> bool:
        """Return whether the last reading is not believed."""
        return bool(self.held) or self.jumped or not isnan(self.stuck)


@often_replaced
class BoardMemory(NamedTuple):
    """The memory of the sensors of one board.

    Attributes:
        seen: Number of readings, counted up to a limit.
        special: Whether a sensor is not calm.
        doubted: Number indexes that depend on a sensor whose last reading is not believed.
    """

    channels: tuple[SensorMemory, ...]
    seen: int = 0
    special: bool = False
    doubted: frozenset[int] = frozenset()

    def after(self, readings: int, spec: PlausibilitySpec) -> BoardMemory:
        """Return it after so many readings in which every limit was kept."""
        if self.seen > spec.hold_back or not readings:
            return self
        seen = min(self.seen + readings, spec.hold_back + 1)
        channels = tuple(channel._replace(seen=seen - 1) for channel in self.channels)
        return self._replace(channels=channels, seen=seen)


class Reading(NamedTuple):
    """The circumstances of one frame of a board.

    Attributes:
        before: Numbers after the board's previous frame.
        elapsed_s: Time since that frame.
        now_s: Time of this frame.
    """

    before: Numbers
    elapsed_s: float
    now_s: float


# --- one reading: believed, held back, or impossible ------------------------------------------


_ESTABLISHED_S = 1.0
"""An angle that was believed for so long after a jump is established [decided]: longer than the
spikes of the thesis's robot."""


def _weigh(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: SensorMemory,
    numbers: Numbers,
    reading: Reading,
    reports: list[FaultReport],
) -> tuple[SensorMemory, float]:
    """Return the sensor's memory after its value among these numbers, and the value to show."""
    value, now_s = numbers[watch.number], reading.now_s
    possible = watch.low <= value <= watch.high
    step = value - channel.good
    if possible and _follows(watch, channel, numbers, reading):
        return believed(_count_spike(spec, watch, channel, now_s, reports)), value
    if possible and _goes_on(watch, channel, step):
        return channel._replace(
            calm=False, good=value, good_s=now_s, wound=nan, held=(), running=step
        ), value
    held = (*channel.held, value)[-spec.hold_back - 1 :]
    channel = channel._replace(calm=False, held=held)
    if len(held) <= spec.hold_back and not isnan(channel.good):
        return channel, channel.good
    if not possible:
        if not channel.outside and len(held) > spec.hold_back:
            reports.append(watch.outside(value))
            channel = channel._replace(outside=True)
        return channel, nan
    if not watch.joint or channel.seen <= spec.hold_back:
        return believed(channel._replace(since_s=now_s)), value
    reports.append(watch.jumped(channel.good, value))
    wound_on = watch.stiffness * _reach(watch, channel, reading)
    wound = channel.wound if abs(torque(watch, numbers) - channel.wound) <= wound_on else nan
    since_s = now_s if channel.good_s - channel.since_s < _ESTABLISHED_S else inf
    return channel._replace(jumped=True, held=(value, value), wound=wound, since_s=since_s), nan


def believed(channel: SensorMemory) -> SensorMemory:
    """Return the memory with the last reading believed and nothing pending."""
    channel = channel._replace(calm=True, good=nan, good_s=-inf, wound=nan, held=())
    return channel._replace(running=0.0, outside=False, jumped=False, stuck=nan)


def torque(watch: WatchSpec, numbers: Numbers) -> float:
    """Return the torque of the spring behind a joint's motor; NaN if it is not measured."""
    return numbers[watch.torque] if watch.torque >= 0 else nan


def _follows(watch: WatchSpec, channel: SensorMemory, numbers: Numbers, reading: Reading) -> bool:
    """Return whether a value can follow the last believed one, or there is none.

    In time a joint can turn to almost any angle. So where a joint seems to stay at an impossible
    angle, time does not make that angle possible.
    """
    moved = _least(watch, channel.good, channel.wound, numbers)
    if moved > _reach(watch, channel, reading):
        return False
    if not watch.joint or not channel.held:
        return True
    step, turned = _motion(watch, channel.held[-1], torque(watch, reading.before), numbers)
    return not moved > max(step, turned)  # the step, if the other is unknown


def _reach(watch: WatchSpec, channel: SensorMemory, reading: Reading) -> float:
    """Return the largest motion of the motor since the last believed value."""
    return watch.rate * max(reading.now_s - channel.good_s, reading.elapsed_s) + watch.slack


def _motion(watch: WatchSpec, before: float, wound: float, numbers: Numbers) -> tuple[float, float]:
    """Return how far a joint has turned, and how far its motor; NaN if that is unknown.

    The spring between them has unwound by the difference. Others can turn the joint, but not the
    motor.

    Args:
        watch: The joint's sensor.
        before: Its value before.
        wound: The torque of the spring at that time.
        numbers: Its value and torque now are among them.
    """
    step = numbers[watch.number] - before
    unwound = (torque(watch, numbers) - wound) / watch.stiffness
    least, most = step + unwound / (1 + watch.spring), step + unwound / (1 - watch.spring)
    return abs(step), 0.0 if least * most < 0 else min(abs(least), abs(most))


def _least(watch: WatchSpec, before: float, wound: float, numbers: Numbers) -> float:
    """Return the smallest motion of a joint's motor that explains its value after another one.

    A joint faster than its motor is a spring's: one that loses torque, or that others turn against
    the torque that it bears already, which may exceed what its motor can wind.
    """
    step, turned = _motion(watch, before, wound, numbers)
    now = torque(watch, numbers)
    explained = abs(now) <= max(abs(wound), watch.winds) or now * wound > 0
    return min(step, turned) if explained else step


def _goes_on(watch: WatchSpec, channel: SensorMemory, step: float) -> bool:
    """Return whether the value continues a trend, or the readings held back."""
    if channel.held:
        before = channel.held[-1] - channel.good
        if before * step > 0 and abs(step) - abs(before) > watch.slack / 2:
            return True
    return channel.running * step > 0


def _weigh_jumped(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: SensorMemory,
    numbers: Numbers,
    reading: Reading,
    reports: list[FaultReport],
) -> tuple[SensorMemory, float]:
    """Return the memory of a joint that has jumped; it is believed again after it jumps back.

    In time a joint can turn to almost any angle, so being near the last believed value is not
    enough. Nor is a jump to the very angle that was not believed before. A torque that has jumped
    with the angle, so that `wound` is unknown, explains nothing.

    The angle from which it has jumped may itself have been a spike, if it had been believed only
    since a jump shortly before. Then readings that follow one another for longer are believed.
    """
    value, first, since_s = numbers[watch.number], channel.held[0], channel.since_s
    once = watch.rate * reading.elapsed_s + watch.slack
    wound = nan if isnan(channel.wound) else torque(watch, reading.before)
    again = _least(watch, channel.held[-1], wound, numbers) > once
    since_s = reading.now_s if again and since_s < inf else since_s
    moved = _least(watch, channel.good, channel.wound, numbers)
    back = again and moved <= _reach(watch, channel, reading) and abs(value - first) > watch.slack
    proven = reading.now_s - since_s >= _ESTABLISHED_S and value != first
    if (back or proven) and watch.low <= value <= watch.high:
        return believed(channel._replace(since_s=reading.now_s if back else since_s)), value
    return channel._replace(held=(first, value), since_s=since_s), nan


def _count_spike(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: SensorMemory,
    now_s: float,
    reports: list[FaultReport],
) -> SensorMemory:
    """Return the memory after the readings held back, if any, turned out to be a spike.

    A sensor that spikes often is reported.
    """
    if not channel.held:
        return channel
    spikes = (*channel.spikes, now_s)[-spec.spikes :]
    channel = channel._replace(spikes=spikes, hidden=channel.hidden + 1)
    within_s = now_s - spikes[0]
    often = len(spikes) == spec.spikes and within_s <= spec.spikes_within_s
    if not often or now_s - channel.spiking_s <= spec.spikes_within_s:
        return channel
    reports.append(watch.spiking(spec.spikes, within_s))
    return channel._replace(spiking_s=now_s)


# --- a motion, against the setpoint of its motor ----------------------------------------------


Rows: TypeAlias = Sequence[Sequence[int]]


class MotionRows(NamedTuple):
    """The rows of a board's motions, see :mod:`pirate_sm.core._engine.sensing.evaluator`.

    Attributes:
        kept: Runs rows, and returns whether all limits are kept; None if no motion is judged.
    """

    stuck: Rows = ()
    rest: Rows = ()
    kept: Callable[[Rows], bool] | None = None

    def repeated(self, cells: Sequence[float]) -> dict[int, tuple[float, float]]:
        """Return the constant reading of each sensor that shows one, and since when it does."""
        return {place: (cells[at], cells[at + 1]) for _, _, at, _, place in self.stuck}


NOTHING_COMPARED = MotionRows()


def _after_motion(
    spec: PlausibilitySpec,
    watched: WatchedSpec,
    channels: Sequence[SensorMemory],
    motion: MotionRows,
    cells: list[float],
    now_s: float,
) -> tuple[Sequence[SensorMemory], list[FaultReport]]:
    """Return the sensors' memories after a comparison with their motors' setpoints, and faults.

    Args:
        spec: Thresholds of the robot.
        watched: The board's sensors.
        channels: Their memories, which are returned as they are where nothing is found.
        motion: The comparison.
        cells: All cells, with the signals as reported. What is remembered of motions is changed.
        now_s: When the frame was received.
    """
    found: list[tuple[int, FaultReport]] = []
    if motion.kept is None:
        return channels, []
    if not motion.kept(motion.stuck):
        for _, number, memory, _, place in motion.stuck:
            value, channel = cells[number], channels[place]
            stays = now_s - cells[memory + 1] >= spec.stuck_after_s
            if stays and value != channel.stuck:
                found.append((place, watched.sensors[place].stuck(spec.stuck_after_s)))
                channel = channel._replace(
                    calm=False, good=value, good_s=now_s, wound=nan, stuck=value
                )
                channels = [*channels[:place], channel, *channels[place + 1 :]]
    believed = [
        (watch.number, cells[watch.number], channel.good)
        for watch, channel in zip(watched.sensors, channels, strict=True)
        if not channel.calm
    ]
    for number, _, good in believed:
        cells[number] = good
    if not motion.kept(motion.rest):
        for _, _, memory, _, place in motion.rest:
            if cells[memory + 6] == JUST_MOVED:
                cells[memory + 6] = 1.0
                found.append((place, watched.sensors[place].moves()))
    for number, value, _ in believed:
        cells[number] = value
    return channels, [report for _, report in sorted(found, key=itemgetter(0))]


# --- all sensors of a board -------------------------------------------------------------------


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
    channels, found = _after_motion(spec, watched, channels, motion, numbers, reading.now_s)
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
    judge = _weigh_jumped if channel.jumped else _weigh
    channel, shown[watch.number] = judge(spec, watch, channel, shown, reading, reports)
    return channel
