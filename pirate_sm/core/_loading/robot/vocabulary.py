"""Build the vocabulary of regions, channels, derived signals and the detector's words."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import Literal

from pirate_sm.core._engine.robot.robot_spec import ChartTable, WordCondition
from pirate_sm.core._engine.sensing.board_spec import WheelSpec
from pirate_sm.core._engine.sensing.environment import JOINTS, SEGMENTS
from pirate_sm.core._engine.state import OUTSIDE
from pirate_sm.core._expressions import (
    EnumType,
    ExpressionError,
    NumberType,
    Vocabulary,
    compile_condition,
)
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.derived_signals import add_derived
from pirate_sm.core._loading.robot.signals import Signals, check_name
from pirate_sm.core._model import derived as kinds
from pirate_sm.core._model import profile as model
from pirate_sm.core.units import ANGLE, DIMENSIONLESS, SPEED, TIME, QuantityError, parse_quantity

DETECTOR, SEGMENT, JOINT = OUTSIDE


def resolve_signals(
    profile: model.Profile,
    table: ChartTable,
    polarity: Literal["normal", "mirrored"],
    problems: Problems,
) -> Signals:
    """Return the robot's signals with types and indexes; report their faults."""
    signals = Signals(profile, problems, polarity)
    for name, conversion in profile.conversions.items():
        path = ("conversions", name, "scale")
        signals.scales[name] = signals.constant(conversion.scale, path)
    types: dict[str, NumberType | EnumType] = {}
    for region, states in zip(table.regions, table.states, strict=True):
        types[region] = EnumType(states)
    types[DETECTOR] = EnumType(tuple(profile.detector.words))
    types[SEGMENT] = EnumType(SEGMENTS)
    types[JOINT] = EnumType(JOINTS)
    for word in profile.detector.words:
        check_name(DETECTOR, EnumType((word,)), ("detector", "words", word), problems, key=True)
    _measured(signals, types)
    _outside(signals, types)
    add_derived(signals, types)
    problems.raise_errors()
    signals.vocabulary = Vocabulary(types)
    signals.wheels = _wheels(signals)
    for number, link in enumerate(profile.body.links):
        if link.roll is not None:
            signals.number(link.roll, ("body", "links", number, "roll"), ANGLE)
    ruler, path = profile.simulation.ruler, ("simulation", "ruler", "signal")
    if ruler and ruler.signal in profile.outside:
        signals.number(ruler.signal, path, SPEED)
    elif ruler:
        problems.add_unknown("robot.signal", path, "outside signal", ruler.signal, profile.outside)
    return signals


def _outside(signals: Signals, types: dict[str, NumberType | EnumType]) -> None:
    """Add the types of the signals that are measured outside, or report what is wrong."""
    problems = signals.problems
    for name, outside in signals.profile.outside.items():
        if name in types:
            problems.add("robot.signal", ("outside", name), f"'{name}' is declared twice", key=True)
        try:
            types[name] = NumberType(parse_quantity(f"1 {outside.unit}").dimension)
        except QuantityError:
            at, message = ("outside", name, "unit"), f"unknown unit '{outside.unit}'"
            problems.add("robot.signal", at, message, expected="a unit such as 'm/s'")
            continue
        check_name(name, types[name], ("outside", name), problems, key=True)


def _measured(signals: Signals, types: dict[str, NumberType | EnumType]) -> None:
    for number, board in enumerate(signals.profile.boards):
        for place, channel in enumerate(board.channels):
            path: Path = ("boards", number, "channels", place)
            convert = channel.convert
            if convert is not None and convert not in signals.scales:
                signals.problems.add_unknown(
                    "robot.conversion", (*path, "convert"), "conversion", convert, signals.scales
                )
                continue
            if channel.signal is None:
                continue
            if channel.signal in types:
                signals.problems.add(
                    "robot.signal", (*path, "signal"), f"'{channel.signal}' is declared twice"
                )
            dimension = signals.scales[convert][1] if convert else DIMENSIONLESS
            types[channel.signal] = NumberType(dimension)
            check_name(channel.signal, types[channel.signal], (*path, "signal"), signals.problems)


def _wheels(signals: Signals) -> tuple[WheelSpec, ...]:
    profile = signals.profile
    slots = {slot.wheel: index for index, slot in enumerate(profile.slots) if slot.wheel}
    found: list[WheelSpec] = []
    for number, wheel in enumerate(profile.body.wheels):
        path: Path = ("body", "wheels", number)
        angle = signals.number(wheel.angle, (*path, "angle"), ANGLE)
        speed = signals.number(wheel.speed, (*path, "speed"), ANGLE / TIME)
        if wheel.name not in slots:
            signals.problems.add("robot.slot", path, f"no slot drives '{wheel.name}'")
            continue
        slot = slots[wheel.name]
        mirrored = signals.polarity == "mirrored" and profile.slots[slot].mirrors
        sign = -wheel.direction if mirrored else wheel.direction
        metres_per_rad = profile.body.wheel_radius * sign
        own = WheelSpec(len(found), angle, speed, slot, metres_per_rad)
        found.append(_with_motor(signals, own))
    return tuple(found)


def _with_motor(signals: Signals, wheel: WheelSpec) -> WheelSpec:
    """Return a wheel with what its motor can do, and the signal that shows its current."""
    profile, slot = signals.profile, signals.profile.slots[wheel.slot]
    motor, radius_m = profile.motors[slot.motor], abs(wheel.metres_per_rad)
    channels = [c for board in profile.boards for c in board.channels if c.slot == slot.name]
    load = next((c.signal for c in channels if c.senses == "current" and c.signal), "")
    scales = [
        signals.constant(each.scale, ("derived", name, "scale"))[0]
        for name, each in profile.derived.items()
        if isinstance(each, kinds.TorqueOf) and each.torque_of == load
    ]
    stall_nm = motor.stall_torque or 0.0
    nm_per_a = scales[0] if scales else stall_nm / (motor.stall_current or inf)
    return wheel._replace(
        load=signals.vocabulary.numbers.index(load) if load and nm_per_a else -1,
        n_per_a=nm_per_a / radius_m,
        stall_n=stall_nm / radius_m,
        drag_n=(motor.dead_drag or 0.0) / radius_m,
        top_m_s=(motor.no_load_speed or inf) * radius_m,
    )


def resolve_words(signals: Signals) -> tuple[WordCondition, ...]:
    """Return the conditions of the words that have one, in the profile's order; report faults."""
    return tuple(_conditions(signals))


def _conditions(signals: Signals) -> Iterator[WordCondition]:
    for name, word in signals.profile.detector.words.items():
        if word.when is None:
            continue
        try:
            when = compile_condition(word.when, signals.vocabulary)
        except ExpressionError as error:
            signals.problems.add_expression(("detector", "words", name, "when"), error)
            continue
        yield WordCondition(name, when, word.held)


def words_behind(profile: model.Profile) -> frozenset[str]:
    """Return the detector's words that mean that the last wheel has passed the bend."""
    last = profile.body.wheels[-1].name
    return frozenset(
        name
        for name, word in profile.detector.words.items()
        if word.forward and word.forward.wheel == last and word.forward.passed >= 0.0
    )
