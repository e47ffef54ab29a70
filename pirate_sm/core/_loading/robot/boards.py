"""Resolve the channels and derived signals of each board to indexes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from pirate_sm.core._engine.robot.robot_spec import FaultSpec
from pirate_sm.core._engine.sensing.board_spec import BoardSpec, DerivedSpec
from pirate_sm.core._loading.robot.sensor_limits import watched
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model import derived as kinds
from pirate_sm.core._model import profile as model


def resolve_boards(signals: Signals, faults: tuple[FaultSpec, ...]) -> Mapping[int, BoardSpec]:
    """Return the specification of each reporting board, with the fault rules that depend on it."""
    listened = [
        (number, board)
        for number, board in enumerate(signals.profile.boards)
        if board.fitted and board.channels_fitted and any(c.signal for c in board.channels)
    ]
    names = signals.vocabulary.numbers
    shared = {signals.first_of(kind) for kind in ("odometry_of", "bound_of", "speed_of")}
    shared |= {
        names.index(name)
        for name, derived in signals.profile.derived.items()
        if isinstance(derived, kinds.Traction)
    }
    shared |= {names.index(name) for name in signals.profile.outside}
    found: dict[int, BoardSpec] = {}
    for position, (number, board) in enumerate(listened):
        own = _board(signals, number, board, position)
        mine = {names[index] for index in own.numbers}
        rules = tuple(
            index
            for index, fault in enumerate(faults)
            if fault.when.names & mine
            or not {names.index(n) for n in fault.when.names if n in names} - shared
        )
        limits = watched(signals.profile, board, own)
        found[board.id] = replace(own, faults=rules, watched=limits)
    return found


def _board(signals: Signals, number: int, board: model.Board, position: int) -> BoardSpec:
    names = signals.vocabulary.numbers
    channels = tuple(
        (place, names.index(channel.signal), _scale(signals, channel))
        for place, channel in enumerate(board.channels)
        if channel.signal
    )
    told = {names[target] for _, target, _ in channels}
    computed: list[DerivedSpec] = []
    slots = [slot.name for slot in signals.profile.slots]
    for name, derived in signals.profile.derived.items():
        target = names.index(name)
        match derived:
            case kinds.RateOf(rate_of=source) if source in told:
                computed.append(DerivedSpec("rate", target, (names.index(source),)))
            case kinds.TorqueOf(torque_of=source, slot=slot, scale=scale) if source in told:
                factor = signals.constant(scale, ("derived", name, "scale"))[0]
                if slot in slots:
                    of, index = (names.index(source),), slots.index(slot)
                    computed.append(DerivedSpec("torque", target, of, factor, slot=index))
            case kinds.RollOf() | kinds.PitchOf() | kinds.NormOf():
                how, sources = _vector(derived)
                if set(sources) <= told:
                    computed.append(DerivedSpec(how, target, tuple(map(names.index, sources))))
            case kinds.DiameterOf(diameter_of=part):
                computed += _diameter(signals, part, told, target)
            case kinds.RateOf() | kinds.TorqueOf():
                pass  # without its source
            case (
                kinds.OdometryOf()
                | kinds.BoundOf()
                | kinds.SpeedOf()
                | kinds.RobotSpeedOf()
                | kinds.SlipSpeedOf()
                | kinds.SlipOf()
                | kinds.NormalForceOf()
                | kinds.FrictionUsedOf()
                | kinds.FrictionOf()
                | kinds.LeastOf()
            ):
                pass  # made of all wheels, see also `traction_signals`
    wheels = tuple(w for w in signals.wheels if names[w.angle] in told)
    return BoardSpec(board.id, board.module, position, channels, tuple(computed), wheels, ())


def _scale(signals: Signals, channel: model.Channel) -> float:
    return signals.scales[channel.convert][0] if channel.convert else 1.0


def _diameter(signals: Signals, part: str, told: set[str], target: int) -> list[DerivedSpec]:
    body = signals.profile.body
    apex = body.parts[part].apex if part in body.parts else ""
    if apex not in told:
        return []
    index = signals.vocabulary.numbers.index(apex)
    # Eq. 3-2 assumes two legs of equal length.
    more = 2 * body.wheel_radius
    return [DerivedSpec("diameter", target, (index,), body.legs_m(part)[0], more)]


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
