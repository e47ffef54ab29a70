"""Determine the types of derived signals, and check their sources."""

from __future__ import annotations

from collections.abc import Mapping

from pirate_sm.core._expressions import EnumType, NumberType
from pirate_sm.core._loading.problems import Path
from pirate_sm.core._loading.robot.signals import Signals, check_name
from pirate_sm.core._model import derived as kinds
from pirate_sm.core._model import profile as model
from pirate_sm.core.units import (
    ANGLE,
    CURRENT,
    DIMENSIONLESS,
    FORCE,
    LENGTH,
    SPEED,
    TIME,
    TORQUE,
    Dimension,
)


def add_derived(signals: Signals, types: dict[str, NumberType | EnumType]) -> None:
    """Add the types of all derived signals; report signals that cannot be derived."""
    profile = signals.profile
    told = [c.signal for board in profile.boards for c in board.channels if c.signal]
    hidden = len(set(told)) < len(told)  # one that is told twice hides the one that is missing
    for name, derived in profile.derived.items():
        path: Path = ("derived", name)
        if name in types:
            signals.problems.add("robot.signal", path, f"'{name}' is declared twice", key=True)
        taken = _taken(profile, derived)
        for source in _sources(derived):
            valid = _valid_sources(profile, derived, types)
            if source not in valid and not hidden:
                known, message = sorted({*valid} - taken), f"'{source}' is not known here"
                signals.problems.add_unknown(
                    "robot.signal", path, "signal", source, known, message=message
                )
        types[name] = NumberType(_dimension(signals, derived, types, path))
        check_name(name, types[name], path, signals.problems, key=True)


def _sources(derived: kinds.Derived) -> tuple[str, ...]:
    value = getattr(derived, next(kind for kind in kinds.DERIVED_KINDS if hasattr(derived, kind)))
    return (value,) if isinstance(value, str) else tuple(value)


def _taken(profile: model.Profile, derived: kinds.Derived) -> set[str]:
    """Return the sources of which there is such a signal already, so that no other is meant."""
    if not isinstance(derived, kinds.RateOf | kinds.TorqueOf):
        return set()
    alike = [each for each in profile.derived.values() if type(each) is type(derived)]
    return {source for each in alike if each is not derived for source in _sources(each)}


def _valid_sources(
    profile: model.Profile, derived: kinds.Derived, types: Mapping[str, object]
) -> list[str]:
    match derived:
        case kinds.DiameterOf():
            return list(profile.body.parts)
        case (
            kinds.OdometryOf()
            | kinds.SpeedOf()
            | kinds.RobotSpeedOf()
            | kinds.SlipSpeedOf()
            | kinds.SlipOf()
            | kinds.NormalForceOf()
            | kinds.FrictionUsedOf()
            | kinds.FrictionOf()
        ):
            return [wheel.name for wheel in profile.body.wheels]
        case kinds.BoundOf():
            odometry = [n for n, d in profile.derived.items() if isinstance(d, kinds.OdometryOf)]
            return odometry[:1]
        case (
            kinds.RateOf()
            | kinds.TorqueOf()
            | kinds.RollOf()
            | kinds.PitchOf()
            | kinds.NormOf()
            | kinds.LeastOf()
        ):
            measured = [c.signal for board in profile.boards for c in board.channels if c.signal]
            numbers = [name for name, kind in types.items() if isinstance(kind, NumberType)]
            return [*numbers, *measured]  # also those with a faulty conversion


def _dimension(  # noqa: C901 - one case for each kind
    signals: Signals, derived: kinds.Derived, types: Mapping[str, NumberType | EnumType], path: Path
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
        case kinds.NormOf(norm_of=sources) | kinds.LeastOf(least_of=sources):
            return of(sources[0])
        case kinds.SpeedOf() | kinds.RobotSpeedOf() | kinds.SlipSpeedOf():
            return SPEED
        case kinds.SlipOf() | kinds.FrictionOf() | kinds.FrictionUsedOf():
            return DIMENSIONLESS
        case kinds.NormalForceOf():
            return FORCE
        case kinds.DiameterOf() | kinds.OdometryOf() | kinds.BoundOf():
            return LENGTH
