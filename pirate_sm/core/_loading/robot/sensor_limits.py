"""Derive the limits of sensors of motors and accelerations from motors and thresholds."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, pi

from pirate_sm.core._engine.sensing.board_spec import (
    BoardSpec,
    PlausibilitySpec,
    WatchedSpec,
    WatchSpec,
)
from pirate_sm.core._model import profile as model

_DEGREE = pi / 180


def thresholds(profile: model.Profile) -> PlausibilitySpec:
    """Return the thresholds common to all sensors; their names there have no unit."""
    names = [name.removesuffix("_s") for name in PlausibilitySpec._fields]
    return PlausibilitySpec._make(getattr(profile.plausibility, name) for name in names)


def watched(profile: model.Profile, board: model.Board, spec: BoardSpec) -> WatchedSpec:
    """Return the board's sensors that measure a motor or an acceleration, with their limits."""
    numbers = {place: number for place, number, _ in spec.channels}
    slots = {slot.name: (index, slot) for index, slot in enumerate(profile.slots)}
    found = []
    for place, number in sorted(numbers.items()):
        channel = board.channels[place]
        resting = (number, *_resting_on(spec, number))
        name = channel.signal or channel.name
        most = profile.plausibility.acceleration
        if most is not None and (channel.senses or "").startswith("acc"):
            found.append(WatchSpec(number, name, resting, low=-most, high=most, unit="m/s^2"))
        if channel.slot not in slots:
            continue
        index, slot = slots[channel.slot]
        watch = WatchSpec(number, name, resting, slot=index, of=slot.drives)
        if channel.senses == "angle":
            watch = _angle(profile, board, watch, slot, numbers)
        else:
            watch = _bounded(profile, watch, slot, channel.senses)
        found.append(watch)
    return WatchedSpec(tuple(found))


def _bounded(
    profile: model.Profile, watch: WatchSpec, slot: model.Slot, senses: model.Sense | None
) -> WatchSpec:
    """Return the limits of a torque or a current."""
    own, motor = profile.plausibility, profile.motors[slot.motor]
    if senses == "torque" and motor.stall_torque is not None:
        most = own.overtorque * motor.stall_torque
        return watch._replace(low=-most, high=most, unit="Nm")
    if senses == "current" and motor.stall_current is not None:
        most = own.overcurrent * motor.stall_current
        return watch._replace(low=-most, high=most, unit="A")
    return watch


def _angle(
    profile: model.Profile,
    board: model.Board,
    watch: WatchSpec,
    slot: model.Slot,
    numbers: Mapping[int, int],
) -> WatchSpec:
    """Return the limits of the angle of a joint, a wheel or a roll joint."""
    own, motor = profile.plausibility, profile.motors[slot.motor]
    watch = watch._replace(unit="deg", per_unit=_DEGREE)
    if motor.no_load_speed is not None:
        rate = own.overspeed * motor.no_load_speed
        watch = watch._replace(rate=rate, slack=own.joint_slack)
    if slot.wheel is not None:
        # The wheels of a falling robot may turn: that must be reported at once.
        return watch._replace(slack=own.wheel_slack, moved=own.wheel_moved)
    stop = next((j.end_stop for j in profile.body.joints if j.name == slot.joint), None)
    if stop is None:
        return watch
    most = stop + own.beyond_stop
    watch = watch._replace(low=-most, high=most, joint=True, moved=own.joint_moved)
    torque = _of_motor("torque", board.channels, slot, numbers)
    if torque >= 0 and motor.stiffness is not None and motor.no_load_speed is not None:
        # What others push shows as torque, so that the motor's own speed is the limit.
        watch = watch._replace(torque=torque, stiffness=motor.stiffness, rate=motor.no_load_speed)
        winds = inf if motor.stall_torque is None else motor.stall_torque
        watch = watch._replace(spring=own.spring, winds=winds)
    load = _of_motor("current", board.channels, slot, numbers)
    loop, full = motor.position_loop, motor.stall_current
    if load < 0 or loop is None or full is None:
        return watch
    least_duty = own.surely_driven * loop.least_duty
    return watch._replace(load=load, full_load=full, least_duty=least_duty)


def _of_motor(
    senses: model.Sense,
    channels: tuple[model.Channel, ...],
    slot: model.Slot,
    numbers: Mapping[int, int],
) -> int:
    """Return the number index of the motor's torque or current; -1 without one."""
    for place, channel in enumerate(channels):
        if channel.senses == senses and channel.slot == slot.name:
            return numbers.get(place, -1)
    return -1


def _resting_on(spec: BoardSpec, number: int) -> tuple[int, ...]:
    """Return the numbers of the board that depend on this one."""
    return tuple(each.target for each in spec.derived if number in each.sources)
