"""Compare the motion that a sensor shows with the setpoint of its motor."""

from __future__ import annotations

from math import inf, isnan, nan

from pirate_sm.engine.sensing.plausibility_spec import PlausibilitySpec, WatchSpec
from pirate_sm.engine.sensing.sensor_memory import Numbers, Reading, SensorMemory
from pirate_sm.model.events import FaultReport
from pirate_sm.model.fault_codes import BuiltInFault


def after_motion(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: SensorMemory,
    numbers: Numbers,
    reading: Reading,
    reports: list[FaultReport],
) -> SensorMemory:
    """Return the memory of a motion sensor after a comparison with its motor's setpoint."""
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
    channel: SensorMemory,
    value: float,
    free: bool,
    now_s: float,
    reports: list[FaultReport],
) -> SensorMemory:
    """Report a sensor without motion although its motor is driven without load."""
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
    reports.append(watch.report(BuiltInFault.SENSOR_STUCK, message))
    return channel._replace(calm=False, good=value, good_s=now_s, wound=nan, stuck=value)


def _unasked(
    spec: PlausibilitySpec,
    watch: WatchSpec,
    channel: SensorMemory,
    good: float,
    since_s: float,
    reports: list[FaultReport],
) -> SensorMemory:
    """Report a motion although no wheel is driven and the setpoints have not changed."""
    if isnan(good):
        return channel
    if channel.rest_of_s != since_s:
        return channel._replace(rest=good, rest_of_s=since_s, proven=False, away=0, unasked=False)
    if abs(good - channel.rest) <= watch.moved:
        calm = channel.proven and channel.away == 0
        return channel if calm else channel._replace(proven=True, away=0)
    if not channel.proven and channel.away < spec.moved_readings:
        # Each of the two readings may be corrupt.
        return channel._replace(rest=good, away=channel.away + 1)
    if channel.away + 1 < spec.moved_readings:
        return channel._replace(away=channel.away + 1)
    if channel.unasked:
        return channel
    message = f"{watch.name} moves though nothing was asked of its motor"
    reports.append(watch.report(BuiltInFault.MOTION_UNASKED, message))
    return channel._replace(unasked=True)
