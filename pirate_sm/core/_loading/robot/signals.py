"""Signals of a robot by name: their types, their sources, and the vocabulary of expressions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Literal, TypeAlias

from pirate_sm.core._engine.robot.robot_spec import ChartTable, WordCondition
from pirate_sm.core._engine.sensing.board_spec import LinkSpec, WheelSpec
from pirate_sm.core._engine.sensing.environment import JOINTS, SEGMENTS
from pirate_sm.core._engine.state import OUTSIDE
from pirate_sm.core._expressions import (
    EnumType,
    ExpressionError,
    NumberType,
    Vocabulary,
    compile_condition,
    compile_expression,
)
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._model.robot import profile as model
from pirate_sm.core._model.robot import signals as kinds
from pirate_sm.core.spelling import nearest
from pirate_sm.core.units import (
    ANGLE,
    CURRENT,
    DIMENSIONLESS,
    SPEED,
    TIME,
    TORQUE,
    Dimension,
    QuantityError,
    parse_quantity,
)

_NOTHING = Vocabulary({})

_Types: TypeAlias = dict[str, NumberType | EnumType]


@dataclass
class Signals:
    """The robot's vocabulary, with the data for computing it from frames.

    Attributes:
        vocabulary: Its words begin with the regions, so a configuration is a prefix of the words.
        scales: Factor to SI of each conversion.
    """

    profile: model.Profile
    problems: Problems
    polarity: Literal["normal", "mirrored"]
    vocabulary: Vocabulary = _NOTHING
    scales: dict[str, tuple[float, Dimension]] = field(default_factory=dict)
    wheels: tuple[WheelSpec, ...] = ()

    @property
    def link(self) -> LinkSpec:
        """Return the timing of the link."""
        link = self.profile.link
        return LinkSpec(
            link.cycle * self.profile.messages_per_round,
            link.stale_after,
            link.silent_after,
            link.resend_after,
            link.resend_limit,
        )

    def number(self, name: str, path: Path, dimension: Dimension | None = None) -> int:
        """Return the index of a numeric signal; -1 after reporting an unknown name."""
        names, types = self.vocabulary.numbers, self.vocabulary.types
        if name not in names:
            fit = [each for each in names if dimension and types[each] == NumberType(dimension)]
            if path[0] == "body":  # each of its signals is of one wheel or joint
                fit = [each for each in fit if each not in self._of_body]
            self.problems.add(
                "robot.signal",
                path,
                f"there is no signal '{name}'",
                suggestion=nearest(name, fit if dimension else names) or "",
            )
            return -1
        kind = types[name]
        if dimension is not None and kind != NumberType(dimension):
            self.problems.add(
                "robot.signal", path, f"'{name}' is {kind}", expected=str(NumberType(dimension))
            )
        return names.index(name)

    @property
    def _of_body(self) -> set[str | None]:
        """Return the signals that the body names."""
        body = self.profile.body
        of_wheels = {each for wheel in body.wheels for each in (wheel.angle, wheel.speed)}
        of_joints = {each for joint in body.joints for each in (joint.name, joint.torque)}
        return of_wheels | of_joints | {link.roll for link in body.links}

    def index(self, name: str | None) -> int:
        """Return the index of a numeric signal; -1 without one."""
        names = self.vocabulary.numbers
        return names.index(name) if name in names else -1

    def constant(self, text: str, path: Path) -> tuple[float, Dimension]:
        """Return the SI value and dimension of a constant expression such as ``360 deg / 4096``."""
        try:
            expression = compile_expression(text, _NOTHING)
        except ExpressionError as error:
            self.problems.add_expression(path, error)
            return 0.0, DIMENSIONLESS
        if not isinstance(expression.type, NumberType):
            self.problems.add("robot.scale", path, "expected a number with a unit")
            return 0.0, DIMENSIONLESS
        value = expression.evaluate((), ())
        if fault := _no_scale(value):
            self.problems.add("robot.scale", path, f"'{text}' {fault}")
            return 0.0, expression.type.dimension
        assert value is not None
        return value, expression.type.dimension

    def derived_by(self, kind: type[kinds.DerivedSignal], **keys: str) -> int:
        """Return the index of the first derived signal of a kind with these keys, or -1."""
        return self.index(self.profile.derived_by(kind, **keys))


def _no_scale(value: float | None) -> str:
    """Return why a number cannot be a scale; empty if it can be one.

    Simulators divide by scales, to get the counts that a sensor shows.
    """
    if value is None:
        return "divides by zero"
    if value == 0:
        return "is zero: every count would mean the same"
    return "" if isfinite(value) and isfinite(1 / value) else "is too large or too small"


def _check_name(
    name: str, kind: NumberType | EnumType, path: Path, problems: Problems, *, key: bool = False
) -> None:
    """Report a name that conditions cannot use."""
    try:
        Vocabulary({name: kind})
    except ValueError as error:
        problems.add("robot.name", path, str(error), key=key)


def _declare(
    signals: Signals, types: _Types, name: str, dimension: Dimension, path: Path, *, key: bool
) -> None:
    """Add the type of a signal; report a name that is taken or that conditions cannot use."""
    if name in types:
        signals.problems.add("robot.signal", path, f"'{name}' is declared twice", key=key)
    types[name] = NumberType(dimension)
    _check_name(name, types[name], path, signals.problems, key=key)


def _add_derived(signals: Signals, types: _Types) -> None:
    """Add the types of all derived signals; report signals that cannot be derived."""
    profile = signals.profile
    told = [c.signal for board in profile.boards for c in board.channels if c.signal]
    hidden = len(set(told)) < len(told)  # one that is told twice hides the one that is missing
    for name, derived in profile.derived.items():
        path: Path = ("derived", name)
        taken = _taken(profile, derived)
        for source in derived.sources:
            valid = _valid_sources(profile, derived, types)
            if source not in valid and not hidden:
                known, message = sorted({*valid} - taken), f"'{source}' is not known here"
                signals.problems.add_unknown(
                    "robot.signal", path, "signal", source, known, message=message
                )
        kind = types.get(derived.sources[0])
        own = kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS
        if isinstance(derived, kinds.TorqueOf):
            _check_torque(signals, derived, own, path)
        _declare(signals, types, name, derived.dimension(own), path, key=True)


def _taken(profile: model.Profile, derived: kinds.Derived) -> set[str]:
    """Return the signals that already have one of this kind, so that another is meant."""
    if derived.OF != "signals" or len(derived.sources) > 1:
        return set()
    alike = [each for each in profile.derived.values() if type(each) is type(derived)]
    return {source for each in alike if each is not derived for source in each.sources}


def _valid_sources(
    profile: model.Profile, derived: kinds.Derived, types: Mapping[str, object]
) -> list[str]:
    match derived.OF:
        case "parts":
            return list(profile.body.parts)
        case "wheels":
            return [wheel.name for wheel in profile.body.wheels]
        case "odometry":
            odometry = [n for n, d in profile.derived.items() if isinstance(d, kinds.OdometryOf)]
            return odometry[:1]
        case "signals" | "axes":
            measured = [c.signal for board in profile.boards for c in board.channels if c.signal]
            numbers = [name for name, kind in types.items() if isinstance(kind, NumberType)]
            return [*numbers, *measured]  # also those with a faulty conversion


def _check_torque(signals: Signals, derived: kinds.TorqueOf, own: Dimension, path: Path) -> None:
    """Report a scale that makes no torque of what it is derived from, and an unknown slot."""
    dimension = signals.constant(derived.scale, (*path, "scale"))[1] * own
    if own != CURRENT or dimension != TORQUE:
        message = "a torque is a current times a scale such as '0.9 Nm/A'"
        signals.problems.add("robot.scale", path, message)
    if derived.slot not in [each.name for each in signals.profile.slots]:
        message = f"there is no slot '{derived.slot}'"
        signals.problems.add("robot.slot", (*path, "slot"), message)


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
    types: _Types = {}
    for region, states in zip(table.regions, table.states, strict=True):
        types[region] = EnumType(states)
    types[DETECTOR] = EnumType(tuple(profile.detector.words))
    types[SEGMENT] = EnumType(SEGMENTS)
    types[JOINT] = EnumType(JOINTS)
    for word in profile.detector.words:
        _check_name(DETECTOR, EnumType((word,)), ("detector", "words", word), problems, key=True)
    _measured(signals, types)
    _outside(signals, types)
    _add_derived(signals, types)
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


def _outside(signals: Signals, types: _Types) -> None:
    """Add the types of the signals that are measured outside, or report what is wrong."""
    for name, outside in signals.profile.outside.items():
        path: Path = ("outside", name)
        try:
            dimension = parse_quantity(f"1 {outside.unit}").dimension
        except QuantityError:
            at, message = (*path, "unit"), f"unknown unit '{outside.unit}'"
            signals.problems.add("robot.signal", at, message, expected="a unit such as 'm/s'")
            dimension = DIMENSIONLESS
        _declare(signals, types, name, dimension, path, key=True)


def _measured(signals: Signals, types: _Types) -> None:
    for number, board in enumerate(signals.profile.boards):
        for place, channel in enumerate(board.channels):
            path: Path = ("boards", number, "channels", place)
            convert = channel.convert
            if convert is not None and convert not in signals.scales:
                signals.problems.add_unknown(
                    "robot.conversion", (*path, "convert"), "conversion", convert, signals.scales
                )
                continue
            if channel.signal is not None:
                dimension = signals.scales[convert][1] if convert else DIMENSIONLESS
                at = (*path, "signal")
                _declare(signals, types, channel.signal, dimension, at, key=False)


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


def resolve_words(signals: Signals) -> Iterator[WordCondition]:
    """Yield the conditions of the words that have one, in the profile's order; report faults."""
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
