"""Resolve the signals of slip, normal force and friction."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

from pirate_sm.core._engine.sensing.board_spec import (
    BoardSpec,
    TractionSpec,
    WheelSpec,
    WheelTraction,
)
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model import derived as kinds
from pirate_sm.core._model.body import Body
from pirate_sm.core.units import SPEED


def resolve_traction(signals: Signals, boards: Mapping[int, BoardSpec]) -> TractionSpec | None:
    """Return what the robot's signals of traction are made of; None where it has none."""
    profile = signals.profile
    wanted = {n: d for n, d in profile.derived.items() if isinstance(d, kinds.Traction)}
    if not wanted:
        return None
    body, names = profile.body, signals.vocabulary.numbers
    modules = [link.module for link in body.links]
    torques = {joint.wheel: joint.torque for joint in body.joints}
    on_boards = [next((b for b in boards.values() if w in b.wheels), None) for w in signals.wheels]
    wheels = tuple(
        _wheel(signals, wheel, board, wanted)
        for wheel, board in zip(signals.wheels, on_boards, strict=True)
    )
    measured = _measured(signals, wanted)
    mounts = [board.module if board else "" for board in on_boards]
    spec = TractionSpec(
        wheels,
        wheels[-1].board,
        tuple(_index(names, torques.get(wheel.name)) for wheel in body.wheels),
        tuple(modules.index(module) if module in modules else 0 for module in mounts),
        _masses_kg(body),
        measured=_index(names, measured),
        averages_s=profile.outside[measured].averages if measured else 0.0,
        # A frame is late by one way of the link, its echo by both.
        delay_s=profile.link.echo_delay,
    )
    spec = _with_shared(signals, spec, wanted)
    _check(signals, spec, wanted)
    return spec


def _masses_kg(body: Body) -> tuple[float, ...]:
    """Return the mass of each wheel with half of its links."""
    masses = [wheel.mass for wheel in body.wheels]
    for number, link in enumerate(body.links):
        masses[number] += link.mass / 2
        masses[number + 1] += link.mass / 2
    return tuple(masses)


def _wheel(
    signals: Signals,
    wheel: WheelSpec,
    board: BoardSpec | None,
    wanted: Mapping[str, kinds.Traction],
) -> WheelTraction:
    """Return what the signals of one wheel are made of."""
    profile = signals.profile
    slot = profile.slots[wheel.slot]
    motor = profile.motors[slot.motor]
    own = WheelTraction(
        wheel.place,
        board.position if board else -1,
        wheel.slot,
        wheel.speed,
        _torque_of(signals, slot.name),
        wheel.metres_per_rad,
        motor.stall_torque or 0.0,
        motor.no_load_speed or inf,
    )
    return _with_targets(signals, own, profile.body.wheels[wheel.place].name, wanted)


def _with_shared(
    signals: Signals, spec: TractionSpec, wanted: Mapping[str, kinds.Traction]
) -> TractionSpec:
    """Return the signals with those that are made of several wheels."""
    body, names = signals.profile.body, signals.vocabulary.numbers
    for name, derived in wanted.items():
        match derived:
            case kinds.RobotSpeedOf(robot_speed_of=of, agreeing=agreeing):
                rolling = tuple(each for each in spec.wheels if body.wheels[each.place].name in of)
                spec = spec._replace(
                    robot_speed=names.index(name), rolling=rolling, agreeing_m_s=agreeing
                )
            case kinds.LeastOf(least_of=sources):
                known = tuple(_index(names, source) for source in sources)
                spec = spec._replace(least=(*spec.least, (names.index(name), known)))
            case _:
                pass
    return spec


def _torque_of(signals: Signals, slot: str) -> int:
    """Return the number index of the torque of a slot's motor; -1 where none is derived."""
    for name, derived in signals.profile.derived.items():
        if isinstance(derived, kinds.TorqueOf) and derived.slot == slot:
            return signals.vocabulary.numbers.index(name)
    return -1


def _with_targets(
    signals: Signals, wheel: WheelTraction, name: str, wanted: Mapping[str, kinds.Traction]
) -> WheelTraction:
    """Return the wheel with the signals that are made of it."""
    names = signals.vocabulary.numbers
    for signal, derived in wanted.items():
        target = names.index(signal)
        match derived:
            case kinds.SlipSpeedOf(slip_speed_of=of) if of == name:
                wheel = wheel._replace(slip_speed=target)
            case kinds.SlipOf(slip_of=of, unknown_below=limit) if of == name:
                wheel = wheel._replace(slip=target, unknown_below_m_s=limit)
            case kinds.NormalForceOf(normal_force_of=of) if of == name:
                wheel = wheel._replace(normal_force=target)
            case kinds.FrictionUsedOf(friction_used_of=of) if of == name:
                wheel = wheel._replace(friction_used=target)
            case kinds.FrictionOf(friction_of=of, slip_above=above, steady=steady) if of == name:
                wheel = wheel._replace(friction=target, slip_above_m_s=above, steady_s=steady)
            case _:
                pass
    return wheel


def _measured(signals: Signals, wanted: Mapping[str, kinds.Traction]) -> str | None:
    """Return the body speed from outside that slip is measured against."""
    found = set()
    for name, derived in wanted.items():
        if isinstance(derived, kinds.RobotSpeedOf):
            found.add((derived.measured, name, "measured"))
        elif isinstance(derived, kinds.SlipSpeedOf | kinds.SlipOf):
            source = signals.profile.derived.get(derived.speed)
            speed = source.measured if isinstance(source, kinds.RobotSpeedOf) else derived.speed
            found.add((speed, name, "speed"))
    for speed, name, key in sorted(found):
        if speed not in signals.profile.outside:
            signals.problems.add_unknown(
                "robot.signal",
                ("derived", name, key),
                "outside signal",
                speed,
                signals.profile.outside,
                none="no outside signal at all",
            )
        else:
            signals.number(speed, ("derived", name, key), SPEED)
    speeds = sorted({speed for speed, *_ in found})
    if len(speeds) > 1:
        name, key = next((name, key) for speed, name, key in sorted(found) if speed == speeds[-1])
        message = f"slip is measured against one speed, here against {' and '.join(speeds)}"
        signals.problems.add("robot.signal", ("derived", name, key), message)
    return next((speed for speed in speeds if speed in signals.profile.outside), None)


def _check(signals: Signals, spec: TractionSpec, wanted: Mapping[str, kinds.Traction]) -> None:
    """Report signals that can never be known, or that mean nothing."""
    body, types = signals.profile.body, signals.vocabulary.types
    blind = [f"joint {joint.name}" for joint in body.joints if joint.torque is None]
    blind += [f"wheel {body.wheels[w.place].name}" for w in spec.wheels if w.torque < 0]
    known: dict[tuple[str, object], str] = {}
    for name, derived in wanted.items():
        message = ""
        match derived:
            case kinds.LeastOf(least_of=sources):
                others = [each for each in sources if types[each] != types[sources[0]]]
                if others:
                    message = f"'{others[0]}' is {types[others[0]]}, '{sources[0]}' is not"
            case kinds.NormalForceOf() | kinds.FrictionOf() | kinds.FrictionUsedOf() if blind:
                message = f"forces need every torque, that of {blind[0]} is not measured"
            case _:
                pass
        kind = type(derived).__name__
        what = (kind, next(iter(derived.model_dump().values())) if kind != "RobotSpeedOf" else "")
        if kind != "LeastOf" and known.setdefault(what, name) != name:
            message = f"'{known[what]}' is the same signal"
        if message:
            signals.problems.add("robot.signal", ("derived", name), message, key=True)


def _index(names: tuple[str, ...], name: str | None) -> int:
    return names.index(name) if name is not None and name in names else -1
