"""Channels and derived signals become one vocabulary, and each board what its frame tells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from pirate_sm.engine.robot.chart_table import ChartTable
from pirate_sm.engine.robot.robot_spec import BoardSpec, FaultSpec, LinkSpec, Vector, WheelSpec
from pirate_sm.engine.sensing.environment import SEGMENTS
from pirate_sm.expressions import (
    EnumType,
    ExpressionError,
    NumberType,
    Vocabulary,
    compile_expression,
)
from pirate_sm.loading.problems import Path, Problems
from pirate_sm.loading.robot.sensor_limits import watched
from pirate_sm.model import derived as kinds
from pirate_sm.model import profile as model
from pirate_sm.spelling import nearest, one_of
from pirate_sm.units import ANGLE, CURRENT, DIMENSIONLESS, LENGTH, SPEED, TIME, TORQUE, Dimension

DETECTOR, SEGMENT = "detector", "segment"

_NOTHING = Vocabulary({})


@dataclass
class Signals:
    """The robot's vocabulary, and what is needed to fill it from frames.

    Attributes:
        vocabulary: Regions first, so that a configuration is the beginning of the words.
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
        """When signals are stale, boards silent, arrays sent again."""
        link = self.profile.link
        return LinkSpec(
            link.cycle * self.profile.messages_per_round,
            link.stale_after, link.silent_after, link.resend_after, link.resend_limit,
        )  # fmt: skip

    def number(self, name: str, path: Path, dimension: Dimension | None = None) -> int:
        """The index of a numeric signal; -1 and a problem when there is none of that kind."""
        names = self.vocabulary.numbers
        if name not in names:
            self.problems.add(
                "robot.signal", path, f"there is no signal '{name}'",
                suggestion=nearest(name, names) or "",
            )  # fmt: skip
            return -1
        kind = self.vocabulary.types[name]
        if dimension is not None and kind != NumberType(dimension):
            self.problems.add(
                "robot.signal", path, f"'{name}' is {kind}", expected=str(NumberType(dimension))
            )
        return names.index(name)

    def constant(self, text: str, path: Path) -> tuple[float, Dimension]:
        """The SI value and dimension of a constant expression such as ``360 deg / 4096``."""
        try:
            expression = compile_expression(text, _NOTHING)
        except ExpressionError as error:
            self.problems.add_expression(path, error)
            return 0.0, DIMENSIONLESS
        value = expression.evaluate((), ())
        if not isinstance(expression.type, NumberType) or not isinstance(value, float):
            self.problems.add("robot.scale", path, "expected a number with a unit")
            return 0.0, DIMENSIONLESS
        return value, expression.type.dimension

    def first_of(self, kind: str) -> int:
        """The index of the first derived signal of this kind; -1 without one."""
        for name, derived in self.profile.derived.items():
            if hasattr(derived, kind):
                return self.vocabulary.numbers.index(name)
        return -1

    def rate_of(self, name: str) -> int:
        """The index of the signal that is this one's rate; -1 without one."""
        for rate, derived in self.profile.derived.items():
            if isinstance(derived, kinds.RateOf) and derived.rate_of == name:
                return self.vocabulary.numbers.index(rate)
        return -1

    def boards(self, faults: tuple[FaultSpec, ...]) -> Mapping[int, BoardSpec]:
        """What each board that is listened to tells, and which fault rules it can change."""
        listened = [
            (number, board)
            for number, board in enumerate(self.profile.boards)
            if board.fitted and board.channels_fitted and any(c.signal for c in board.channels)
        ]
        names = self.vocabulary.numbers
        shared = {self.first_of("odometry_of"), self.first_of("speed_of")}
        found: dict[int, BoardSpec] = {}
        for position, (number, board) in enumerate(listened):
            own = self._board(number, board, position)
            mine = {names[index] for index in own.numbers}
            rules = tuple(
                index
                for index, fault in enumerate(faults)
                if fault.when.names & mine
                or not {names.index(n) for n in fault.when.names if n in names} - shared
            )
            limits = watched(self.profile, board, own)
            found[board.id] = replace(own, faults=rules, watched=limits)
        return found

    def _board(self, number: int, board: model.Board, position: int) -> BoardSpec:
        names = self.vocabulary.numbers
        channels = tuple(
            (place, names.index(channel.signal), self._scale(channel))
            for place, channel in enumerate(board.channels)
            if channel.signal
        )
        told = {names[target] for _, target, _ in channels}
        rates: list[tuple[int, int]] = []
        torques: list[tuple[int, int, float, int]] = []
        vectors: list[Vector] = []
        diameters: list[tuple[int, float, float, int]] = []
        slots = [slot.name for slot in self.profile.slots]
        for name, derived in self.profile.derived.items():
            target = names.index(name)
            match derived:
                case kinds.RateOf(rate_of=source) if source in told:
                    rates.append((names.index(source), target))
                case kinds.TorqueOf(torque_of=source, slot=slot, scale=scale) if source in told:
                    factor = self.constant(scale, ("derived", name, "scale"))[0]
                    if slot in slots:
                        torques.append((names.index(source), slots.index(slot), factor, target))
                case kinds.RollOf() | kinds.PitchOf() | kinds.NormOf():
                    how, sources = _vector(derived)
                    if set(sources) <= told:
                        vectors.append(Vector(how, tuple(map(names.index, sources)), target))
                case kinds.DiameterOf(diameter_of=part):
                    diameters += self._diameter(part, told, target)
                case kinds.RateOf() | kinds.TorqueOf() | kinds.OdometryOf() | kinds.SpeedOf():
                    pass  # without its source; made of all wheels
        wheels = tuple(w for w in self.wheels if names[w.angle] in told)
        return BoardSpec(
            board.id, board.module, position, channels, tuple(rates), tuple(torques),
            tuple(vectors), tuple(diameters), wheels, (),
        )  # fmt: skip

    def _scale(self, channel: model.Channel) -> float:
        return self.scales[channel.convert][0] if channel.convert else 1.0

    def _diameter(
        self, part: str, told: set[str], target: int
    ) -> list[tuple[int, float, float, int]]:
        body = self.profile.body
        apex = body.parts[part].apex if part in body.parts else ""
        if apex not in told:
            return []
        index = self.vocabulary.numbers.index(apex)
        # Eq. 3-2 takes the V's two legs as equally long.
        return [(index, body.legs_m(part)[0], 2 * body.wheel_radius, target)]


def resolve_signals(
    profile: model.Profile,
    table: ChartTable,
    polarity: Literal["normal", "mirrored"],
    problems: Problems,
) -> Signals:
    """Every signal has a type and an index, or the problems say why not."""
    signals = Signals(profile, problems, polarity)
    for name, conversion in profile.conversions.items():
        path = ("conversions", name, "scale")
        signals.scales[name] = signals.constant(conversion.scale, path)
    types: dict[str, NumberType | EnumType] = {}
    for region, states in zip(table.regions, table.states, strict=True):
        types[region] = EnumType(states)
    types[DETECTOR] = EnumType(tuple(profile.detector.words))
    types[SEGMENT] = EnumType(SEGMENTS)
    for word in profile.detector.words:
        _check_name(DETECTOR, EnumType((word,)), ("detector", "words", word), problems, key=True)
    _measured(signals, types)
    _derived(signals, types)
    problems.raise_errors()
    signals.vocabulary = Vocabulary(types)
    signals.wheels = _wheels(signals)
    for number, link in enumerate(profile.body.links):
        if link.roll is not None:
            signals.number(link.roll, ("body", "links", number, "roll"), ANGLE)
    return signals


def _measured(signals: Signals, types: dict[str, NumberType | EnumType]) -> None:
    for number, board in enumerate(signals.profile.boards):
        for place, channel in enumerate(board.channels):
            path: Path = ("boards", number, "channels", place)
            convert = channel.convert
            if convert is not None and convert not in signals.scales:
                signals.problems.add(
                    "robot.conversion", (*path, "convert"), f"there is no conversion '{convert}'",
                    expected=one_of(signals.scales),
                    suggestion=nearest(convert, signals.scales) or "",
                )  # fmt: skip
                continue
            if channel.signal is None:
                continue
            if channel.signal in types:
                signals.problems.add(
                    "robot.signal", (*path, "signal"), f"'{channel.signal}' is told twice"
                )
            dimension = signals.scales[convert][1] if convert else DIMENSIONLESS
            types[channel.signal] = NumberType(dimension)
            _check_name(channel.signal, types[channel.signal], (*path, "signal"), signals.problems)


def _check_name(
    name: str,
    kind: NumberType | EnumType,
    path: Path,
    problems: Problems,
    *,
    key: bool = False,
) -> None:
    """Conditions must be able to name it."""
    try:
        Vocabulary({name: kind})
    except ValueError as error:
        problems.add("robot.name", path, str(error), key=key)


def _derived(signals: Signals, types: dict[str, NumberType | EnumType]) -> None:
    profile = signals.profile
    told = [c.signal for board in profile.boards for c in board.channels if c.signal]
    hidden = len(set(told)) < len(told)  # one that is told twice hides the one that is missing
    for name, derived in profile.derived.items():
        path: Path = ("derived", name)
        if name in types:
            signals.problems.add("robot.signal", path, f"'{name}' is told twice", key=True)
        for source in _sources(derived):
            valid = _valid_sources(profile, derived, types)
            if source not in valid and not hidden:
                signals.problems.add(
                    "robot.signal", path, f"'{source}' is not known here",
                    expected=one_of(sorted(set(valid))), suggestion=nearest(source, valid) or "",
                )  # fmt: skip
        types[name] = NumberType(_dimension(signals, derived, types, path))
        _check_name(name, types[name], path, signals.problems, key=True)


def _sources(derived: kinds.Derived) -> tuple[str, ...]:
    value = getattr(derived, next(kind for kind in kinds.DERIVED_KINDS if hasattr(derived, kind)))
    return (value,) if isinstance(value, str) else tuple(value)


def _valid_sources(
    profile: model.Profile, derived: kinds.Derived, types: Mapping[str, object]
) -> list[str]:
    match derived:
        case kinds.DiameterOf():
            return list(profile.body.parts)
        case kinds.OdometryOf() | kinds.SpeedOf():
            return [wheel.name for wheel in profile.body.wheels]
        case kinds.RateOf() | kinds.TorqueOf() | kinds.RollOf() | kinds.PitchOf() | kinds.NormOf():
            measured = [c.signal for board in profile.boards for c in board.channels if c.signal]
            numbers = [name for name, kind in types.items() if isinstance(kind, NumberType)]
            return [*numbers, *measured]  # one with a faulty conversion is known all the same


def _dimension(
    signals: Signals,
    derived: kinds.Derived,
    types: Mapping[str, NumberType | EnumType],
    path: Path,
) -> Dimension:
    def of(name: str) -> Dimension:
        kind = types.get(name)
        return kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS

    match derived:
        case kinds.RateOf(rate_of=source):
            return of(source) / TIME
        case kinds.TorqueOf(torque_of=source, slot=slot, scale=scale):
            dimension = signals.constant(scale, (*path, "scale"))[1] * of(source)
            if of(source) != CURRENT or dimension != TORQUE:
                signals.problems.add(
                    "robot.scale", path, "a torque is a current times a scale such as '0.9 Nm/A'"
                )
            if slot not in [each.name for each in signals.profile.slots]:
                signals.problems.add("robot.slot", (*path, "slot"), f"there is no slot '{slot}'")
            return TORQUE
        case kinds.RollOf() | kinds.PitchOf():
            return ANGLE
        case kinds.NormOf(norm_of=sources):
            return of(sources[0])
        case kinds.SpeedOf():
            return SPEED
        case kinds.DiameterOf() | kinds.OdometryOf():
            return LENGTH


def _vector(
    derived: kinds.RollOf | kinds.PitchOf | kinds.NormOf,
) -> tuple[Literal["roll", "pitch", "norm"], tuple[str, ...]]:
    match derived:
        case kinds.RollOf(roll_of=sources):
            return "roll", sources
        case kinds.PitchOf(pitch_of=sources):
            return "pitch", sources
        case kinds.NormOf(norm_of=sources):
            return "norm", sources


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
        found.append(WheelSpec(len(found), angle, speed, slot, profile.body.wheel_radius * sign))
    return tuple(found)
