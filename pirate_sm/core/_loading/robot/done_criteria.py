"""Make of each kind of criterion what sensors must show for it; names become indexes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf
from typing import assert_never

from pirate_sm.core._engine.robot.done_criteria import (
    AngleSet,
    Bound,
    CriterionSpec,
    Demand,
    JointsArrived,
    TorqueBorne,
    WheelTurning,
    only,
    standing,
)
from pirate_sm.core._expressions import NumberType
from pirate_sm.core._loading.problems import Path
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model.robot import done_criteria as model
from pirate_sm.core._model.robot.signals import RateOf
from pirate_sm.core.units import Quantity, describe


def resolve_criterion(done: model.Criterion | None, signals: Signals, path: Path) -> CriterionSpec:
    """Return what sensors must show; where nothing is asked for, accepted setpoints are enough."""
    done = model.Accepted(kind="accepted") if done is None else done
    demands, for_s = tuple(_demands(done, signals, path)), getattr(done, "for_s", 0.0)
    found = CriterionSpec(done.kind, done.SHOWN, done.LACKING, demands, for_s)
    if not isinstance(done, model.Weak) or done.settled is None or done.at_least is None:
        return found
    weakened = tuple(
        each.weakened(done.at_least) if isinstance(each, TorqueBorne | JointsArrived) else each
        for each in demands
    )
    return replace(found, settled=replace(found, demands=weakened, for_s=done.settled))


def _demands(  # noqa: C901 - one case for each kind
    done: model.Criterion, signals: Signals, path: Path
) -> Iterator[Demand]:
    """Yield what must all be true."""
    match done:
        case model.Accepted():
            return
        case model.Stalled():
            for number, name in enumerate(done.joints):
                rate = rate_of(name, signals, "robot.criterion", (*path, "joints", number))
                yield only(Bound(rate, "<", done.still))
            for number, name in enumerate(done.loaded):
                at = (*path, "loaded", number)
                yield resolve_load(done, name, _torque(name, signals, at), signals, at)
        case model.Reached():
            for joint in signals.profile.body.joints if done.or_still is not None else ():
                rate_of(joint.name, signals, "robot.criterion", path)
            yield JointsArrived(done.or_still or 0.0, done.loaded, done.moved)
        case model.Turning():
            wheels = tuple((wheel.slot, wheel.speed) for wheel in signals.wheels)
            yield WheelTurning(wheels, turning_rad_s(done, signals, path))
        case model.Stopped():
            for speeds in _speeds_of_parts(signals):
                yield from standing(speeds, done.below)
        case model.Aligned():
            yield from _angles(done, signals, path)
        case model.Below():
            for signal in _numbers(done.signals, done.limit, signals, path):
                yield only(Bound(signal, "<", done.limit.value))
        case _:
            assert_never(done)


def turning_rad_s(done: model.Turning, signals: Signals, path: Path) -> float:
    """Return the speed above which a wheel turns; report motors without one."""
    if done.share is None:
        return done.above or 0.0
    profile = signals.profile
    motors = [profile.motors[slot.motor] for slot in profile.slots if slot.wheel is not None]
    if any(motor.no_load_speed is None for motor in motors):
        message = "a `share` needs the `no_load_speed` of the motors of all wheels"
        signals.problems.add("robot.criterion", (*path, "share"), message)
    return done.share * min((motor.no_load_speed or inf for motor in motors), default=inf)


def resolve_load(
    load: model.Load, joint: str, torque: int, signals: Signals, path: Path
) -> TorqueBorne:
    """Return the torque that a joint must bear, with this number index; report a missing motor."""
    profile = signals.profile
    slot = next((at for at, each in enumerate(profile.slots) if each.joint == joint), -1)
    motor = profile.motors.get(profile.slots[slot].motor) if slot >= 0 else None
    if load.share is None or motor is None:
        return TorqueBorne(torque, slot, 0.0, load.torque or inf)
    if motor.stall_torque is None:
        message = f"a `share` needs the `stall_torque` of the motor of '{joint}'"
        signals.problems.add("robot.criterion", path, message)
        return TorqueBorne(torque, slot, 0.0, inf)
    return TorqueBorne(torque, slot, load.share * motor.stall_torque, load.at_least or 0.0)


def _speeds_of_parts(signals: Signals) -> tuple[tuple[int, ...], ...]:
    """Return the number indexes of the wheels' speeds, part by part."""
    wheels = signals.profile.body.wheels
    return tuple(
        tuple(spec.speed for spec in signals.wheels if wheels[spec.place].part == part)
        for part in dict.fromkeys(wheel.part for wheel in wheels)
    )


def _angles(done: model.Aligned, signals: Signals, path: Path) -> Iterator[AngleSet]:
    """Yield the demand for each slot; report those that take no angle."""
    for number, name in enumerate(done.slots):
        for index, slot in enumerate(signals.profile.slots):
            if slot.name == name and slot.unit == "angle" and slot.roll:
                angle = signals.number(slot.roll, (*path, "slots", number))
                yield AngleSet(index, angle, done.within, done.leaning)
                break
        else:
            message = f"'{name}' is not a slot that takes an angle"
            signals.problems.add("robot.criterion", (*path, "slots", number), message)


def _numbers(
    names: tuple[str, ...], limit: Quantity, signals: Signals, path: Path
) -> tuple[int, ...]:
    """Return the number indexes of signals; report a limit of another dimension."""
    numbers = tuple(
        signals.number(name, (*path, "signals", number)) for number, name in enumerate(names)
    )
    for name in names:
        kind = signals.vocabulary.types.get(name)
        if isinstance(kind, NumberType) and kind.dimension != limit.dimension:
            message = f"'{name}' is {kind}, and this is {describe(limit.dimension)}"
            signals.problems.add("robot.criterion", (*path, "limit"), message)
            break  # the other signals have the same limit
    return numbers


def rate_of(name: str, signals: Signals, code: str, path: Path) -> int:
    """Return the number index of how fast a joint turns; report a missing one by this code."""
    rate = signals.derived_by(RateOf, rate_of=name)
    if rate < 0:
        message = f"whether '{name}' stands still needs a derived signal {{rate_of: {name}}}"
        signals.problems.add(code, path, message)
    return rate


def _torque(name: str, signals: Signals, path: Path) -> int:
    for place, joint in enumerate(signals.profile.body.joints):
        if joint.name == name and joint.torque is not None:
            return signals.number(joint.torque, ("body", "joints", place, "torque"))
    signals.problems.add("robot.criterion", path, f"'{name}' is not a joint with a torque signal")
    return -1
