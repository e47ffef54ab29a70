"""Judge one reading of a sensor: believe it, hold it back, or report it as impossible."""

from __future__ import annotations

from math import inf, isnan, nan

from pirate_sm.core._engine.sensing.plausibility_spec import PlausibilitySpec, WatchSpec
from pirate_sm.core._engine.sensing.sensor_memory import Numbers, Reading, SensorMemory
from pirate_sm.core._model.events import FaultReport
from pirate_sm.core._model.fault_codes import BuiltInFault

_ESTABLISHED_S = 1.0
"""An angle that was believed for so long after a jump is established [decided]: longer than the
spikes of the thesis's robot."""


def weigh(
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
            reports.append(watch.report(BuiltInFault.SENSOR_RANGE, _outside(watch, value)))
            channel = channel._replace(outside=True)
        return channel, nan
    if not watch.joint or channel.seen <= spec.hold_back:
        return believed(channel._replace(since_s=now_s)), value
    where = f"from {watch.in_words(channel.good)} to {watch.in_words(value)}"
    message = f"{watch.name} has jumped {where}, faster than its motor can turn"
    message = f"{message}: it is unknown until it jumps back"
    reports.append(watch.report(BuiltInFault.SENSOR_JUMPED, message))
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


def weigh_jumped(
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
    message = f"{watch.name} has spiked {spec.spikes} times in {within_s:.1f} s"
    reports.append(watch.report(BuiltInFault.SENSOR_SPIKING, message))
    return channel._replace(spiking_s=now_s)


def _outside(watch: WatchSpec, value: float) -> str:
    low = f"{watch.low / watch.per_unit:.3g}"
    where = f"{low} to {watch.in_words(watch.high)}"
    return f"{watch.name} reports {watch.in_words(value)}, outside {where}"
