"""Decide which sensor values are possible, and report sensors that show impossible ones.

Every value of a frame is compared with what the body and the motors can do. An impossible value
is held back for a few readings, with the last believed value in its place: a spike is over by
then. A value that lasts is believed if it can be true: the next reading goes on the same way (a
trend), or it belongs to a counter, which may have begun anew. The angle of a joint that has
jumped is not believed: nobody can tell which of the two angles is right. It is unknown until it
jumps back. So is a value outside its range, and one whose sensor is stuck.

A joint behind a spring can snap faster than its motor turns. Then the spring unwinds by as much as
the joint has turned, and its torque, which another sensor measures, shows it: such an angle is
believed at once.

Values are SI; unknown is NaN. The thresholds stand in the profile, section ``plausibility``.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan, nan

from pirate_sm.engine.sensing.plausibility_spec import PlausibilitySpec, WatchedSpec, WatchSpec
from pirate_sm.engine.sensing.sensor_memory import Channel, Numbers, Reading, Record
from pirate_sm.model.events import FaultReport
from pirate_sm.model.fault_codes import BuiltInFault


def unseen(watched: WatchedSpec) -> Record:
    """Return the record of a board that has not reported."""
    return Record((Channel(),) * len(watched.sensors))


def begin_anew(record: Record) -> Record:
    """Return the record after a restart, when counters may have begun at zero.

    The angle of a joint survives a restart, so a sensor that was not believed still is not.
    """
    channels = tuple(
        channel._replace(rest_of_s=inf, same_s=inf)
        if channel.jumped or not isnan(channel.stuck)
        else Channel(hidden=channel.hidden)
        for channel in record.channels
    )
    return record._replace(channels=channels, seen=0)


def sift(
    spec: PlausibilitySpec,
    watched: WatchedSpec,
    record: Record,
    numbers: list[float],
    reading: Reading,
) -> tuple[Record, list[FaultReport]]:
    """Replace the numbers that are not to be believed, and report sensors that are wrong.

    Args:
        spec: Thresholds of the robot.
        watched: The board's sensors that have limits.
        record: What is remembered of them.
        numbers: All numbers, those of this board as it reports them; changed in place.
        reading: The circumstances.

    Returns:
        The new record, and the faults that have come to be.
    """
    reports: list[FaultReport] = []
    channels: list[Channel] | None = None
    shown = numbers
    remembered: Sequence[Channel] = record.channels
    if record.special or not _plain(watched, numbers, reading):
        shown = list(numbers)
        channels = [
            _believe(spec, watch, channel, record.seen, shown, reading, reports)
            for watch, channel in zip(watched.sensors, remembered, strict=True)
        ]
        remembered = channels
    setpoints, settled = reading.setpoints, reading.settled
    if setpoints:
        for at, slot, least_duty in watched.moving:
            channel = remembered[at]
            if settled or abs(setpoints[slot]) > least_duty or channel.same_s < inf:
                after = _moved(spec, watched.sensors[at], channel, numbers, reading, reports)
                if after is not channel:
                    remembered = channels = channels or list(remembered)
                    channels[at] = after
    seen = record.seen if record.seen > spec.hold_back else record.seen + 1  # no need of more
    if channels is None:
        return (record if seen == record.seen else record._replace(seen=seen)), reports
    for watch, channel in zip(watched.sensors, channels, strict=True):
        value = numbers[watch.number]
        numbers[watch.number] = nan if channel.stuck == value else shown[watch.number]
    special = any(not channel.calm for channel in channels)
    doubted = frozenset(
        number
        for watch, channel in zip(watched.sensors, channels, strict=True)
        if channel.doubted
        for number in watch.numbers
    )
    return Record(tuple(channels), seen, special, doubted), reports


def _plain(watched: WatchedSpec, numbers: Numbers, reading: Reading) -> bool:
    """Return whether every value is in its range and near the previous one.

    Most frames are like this, and every frame of a simulation passes here.
    """
    before, elapsed_s = reading.before, reading.elapsed_s
    for number, low, high in watched.ranges:
        if not low <= numbers[number] <= high:
            return False
    for number, rate, slack in watched.rates:
        if not abs(numbers[number] - before[number]) <= rate * elapsed_s + slack:
            return False
    return True


def _believe(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: Channel,
    seen: int,
    shown: list[float],
    reading: Reading,
    reports: list[FaultReport],
) -> Channel:
    """Return the channel after a reading; what is shown of it takes its place in ``shown``."""
    if channel.calm:
        good, good_s = reading.before[watch.number], reading.now_s - reading.elapsed_s
        wound = _torque(watch, reading.before)
        channel = channel._replace(good=good, good_s=good_s, seen=seen, wound=wound)
    value = shown[watch.number]
    if isnan(value):
        return channel._replace(calm=False, held=channel.held if channel.jumped else ())
    if value == channel.stuck:
        return channel
    weigh = _weigh_jumped if channel.jumped else _weigh
    if not channel.jumped and _snapped(watch, channel, value, shown, reading):
        return _believed(channel)
    channel, shown[watch.number] = weigh(spec, watch, channel, value, reading, reports)
    return channel


def _snapped(
    watch: WatchSpec, channel: Channel, value: float, numbers: Numbers, reading: Reading
) -> bool:
    """Return whether the spring of a joint has unwound by as much as the joint has turned.

    What is left is the turn of the motor before the spring, which nobody can push.
    """
    if not watch.low <= value <= watch.high:
        return False
    step = value - channel.good
    if abs(step) <= _reach(watch, channel, reading):
        return False
    motor = step + (_torque(watch, numbers) - channel.wound) / watch.stiffness
    elapsed_s = max(reading.now_s - channel.good_s, reading.elapsed_s)
    return abs(motor) <= watch.turns * elapsed_s + watch.slack


def _torque(watch: WatchSpec, numbers: Numbers) -> float:
    return numbers[watch.torque] if watch.torque >= 0 else nan


def _weigh(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: Channel,
    value: float,
    reading: Reading,
    reports: list[FaultReport],
) -> tuple[Channel, float]:
    """Return the channel after this value, and the value that is shown."""
    now_s = reading.now_s
    possible = watch.low <= value <= watch.high
    step = value - channel.good
    if possible and not abs(step) > _reach(watch, channel, reading):  # or nothing to go by
        return _believed(_count_spike(spec, watch, channel, now_s, reports)), value
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
            reports.append(BuiltInFault.SENSOR_RANGE.report(_outside(watch, value)))
            channel = channel._replace(outside=True)
        return channel, nan
    if not watch.joint or channel.seen <= spec.hold_back:
        return _believed(channel), value
    where = f"from {watch.in_words(channel.good)} to {watch.in_words(value)}"
    message = f"{watch.name} has jumped {where}, faster than its motor can turn"
    reports.append(
        BuiltInFault.SENSOR_JUMPED.report(f"{message}: it is unknown until it jumps back")
    )
    return channel._replace(jumped=True, held=(value,)), nan


def _believed(channel: Channel) -> Channel:
    """Return the channel when its last reading is believed and nothing is pending."""
    return channel._replace(calm=True, held=(), running=0.0, outside=False, jumped=False, stuck=nan)


def _reach(watch: WatchSpec, channel: Channel, reading: Reading) -> float:
    """Return how far the value can be from the last believed one."""
    return watch.rate * max(reading.now_s - channel.good_s, reading.elapsed_s) + watch.slack


def _goes_on(watch: WatchSpec, channel: Channel, step: float) -> bool:
    """Return whether the value goes on the way of a trend, or of the readings held back."""
    if channel.held:
        before = channel.held[-1] - channel.good
        if before * step > 0 and abs(step) - abs(before) > watch.slack / 2:
            return True
    return channel.running * step > 0


def _weigh_jumped(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: Channel,
    value: float,
    reading: Reading,
    reports: list[FaultReport],
) -> tuple[Channel, float]:
    """Return the channel of a joint that has jumped, believed again once it has jumped back.

    With time a joint could have turned to almost any angle, so it is not enough that it is near
    the last believed one.
    """
    again = abs(value - channel.held[-1]) > watch.rate * reading.elapsed_s + watch.slack
    near = abs(value - channel.good) <= _reach(watch, channel, reading)
    if again and near and watch.low <= value <= watch.high:
        return _believed(channel), value
    return channel._replace(held=(value,)), nan


def _count_spike(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: Channel,
    now_s: float,
    reports: list[FaultReport],
) -> Channel:
    """Return the channel after the readings held back turned out to be a spike, if there are any.

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
    message = f"{watch.name} has spiked {spec.spikes} times in {within_s:.1f} s"
    reports.append(BuiltInFault.SENSOR_SPIKING.report(message))
    return channel._replace(spiking_s=now_s)


def _outside(watch: WatchSpec, value: float) -> str:
    low = f"{watch.low / watch.per_unit:.3g}"
    where = f"{low} to {watch.in_words(watch.high)}"
    return f"{watch.name} reports {watch.in_words(value)}, outside {where}"


def _moved(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: Channel,
    numbers: Numbers,
    reading: Reading,
    reports: list[FaultReport],
) -> Channel:
    """Return the channel of something that moves, after its motion was compared with its motor."""
    value = numbers[watch.number]
    duty = abs(reading.setpoints[watch.slot])
    if watch.load >= 0 and (duty > watch.least_duty or channel.same_s < inf):
        load = abs(numbers[watch.load])
        free = duty > watch.least_duty and load < spec.unloaded * duty * watch.full_load
        channel = _stuck(spec, watch, channel, value, free, reading.now_s, reports)
    if duty == 0 and reading.settled:
        good = value if channel.calm else channel.good
        channel = _unasked(spec, watch, channel, good, reading.since_s, reports)
    return channel


def _stuck(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: Channel,
    value: float,
    free: bool,
    now_s: float,
    reports: list[FaultReport],
) -> Channel:
    """Report a sensor that shows no motion although its motor is driven and bears no load."""
    if not free:
        return channel if channel.same_s == inf else channel._replace(same_s=inf)
    if channel.same_s == inf or value != channel.same:
        return channel._replace(same=value, same_s=now_s)
    if value == channel.stuck or now_s - channel.same_s < spec.stuck_after_s:
        return channel
    message = (
        f"{watch.name} has shown the same for {spec.stuck_after_s:g} s while its motor is "
        "driven and bears no load: the sensor is stuck, or the motor gets no current"
    )
    reports.append(BuiltInFault.SENSOR_STUCK.report(message))
    return channel._replace(calm=False, good=value, good_s=now_s, wound=nan, stuck=value)


def _unasked(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: Channel,
    good: float,
    since_s: float,
    reports: list[FaultReport],
) -> Channel:
    """Report a motion while every wheel is at rest and nothing new has been asked for."""
    if isnan(good):
        return channel
    if channel.rest_of_s != since_s:
        return channel._replace(rest=good, rest_of_s=since_s, proven=False, away=0, unasked=False)
    if abs(good - channel.rest) <= watch.moved:
        calm = channel.proven and channel.away == 0
        return channel if calm else channel._replace(proven=True, away=0)
    if not channel.proven and channel.away < spec.moved_readings:
        # Either of the two readings may be damaged.
        return channel._replace(rest=good, away=channel.away + 1)
    if channel.away + 1 < spec.moved_readings:
        return channel._replace(away=channel.away + 1)
    if channel.unasked:
        return channel
    message = f"{watch.name} moves though nothing was asked of its motor"
    reports.append(BuiltInFault.MOTION_UNASKED.report(message))
    return channel._replace(unasked=True)
