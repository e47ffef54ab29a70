"""Resolve what a robot senses: signals of each board, limits of sensors, slip and friction."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import inf, pi

from pirate_sm.core._engine.robot.robot_spec import FaultSpec
from pirate_sm.core._engine.sensing.board_spec import (
    BoardSpec,
    DerivedSpec,
    PlausibilitySpec,
    TractionSpec,
    WatchedSpec,
    WatchSpec,
    WheelSpec,
    WheelTraction,
)
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model.robot import profile as model
from pirate_sm.core._model.robot import signals as kinds
from pirate_sm.core._model.robot.body import Body
from pirate_sm.core.units import SPEED, unit_of


def resolve_boards(signals: Signals, faults: tuple[FaultSpec, ...]) -> Mapping[int, BoardSpec]:
    """Return the specification of each reporting board, with the fault rules that depend on it."""
    listened = [
        (number, board)
        for number, board in enumerate(signals.profile.boards)
        if board.fitted and board.channels_fitted and any(c.signal for c in board.channels)
    ]
    names = signals.vocabulary.numbers
    shared = {
        names.index(name)
        for name, derived in signals.profile.derived.items()
        if not any(derived.rows(name, signals.profile.body))
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
        limits = _watched(signals, board, own)
        found[board.id] = replace(own, faults=rules, watched=limits)
    return found


def _board(signals: Signals, number: int, board: model.Board, position: int) -> BoardSpec:
    names = signals.vocabulary.numbers
    channels = tuple(
        (place, names.index(channel.signal), _scale(signals, channel))
        for place, channel in enumerate(board.channels)
        if channel.signal
    )
    measured = {names[target] for _, target, _ in channels}
    computed = tuple(
        row
        for name, derived in signals.profile.derived.items()
        for row in _rows(signals, name, derived, measured)
    )
    wheels = tuple(w for w in signals.wheels if names[w.angle] in measured)
    return BoardSpec(board.id, board.module, position, channels, computed, wheels, ())


def _scale(signals: Signals, channel: model.Channel) -> float:
    return signals.scales[channel.convert][0] if channel.convert else 1.0


def _rows(
    signals: Signals, name: str, derived: kinds.Derived, measured: set[str]
) -> Iterator[DerivedSpec]:
    """Yield how a board derives a signal from those that it measures; nothing if one is missing."""
    rows = tuple(derived.rows(name, signals.profile.body))
    if {source for row in rows for source in row.sources} - measured - {name}:
        return
    names, slots = signals.vocabulary.numbers, [slot.name for slot in signals.profile.slots]
    for row in rows:
        yield DerivedSpec(
            row.operation,
            names.index(name),
            tuple(map(names.index, row.sources)),
            slots.index(row.slot) if row.slot else -1,
            tuple(
                signals.constant(each, ("derived", name))[0] if isinstance(each, str) else each
                for each in row.constants
            ),
        )


_DEGREE = pi / 180


def thresholds(profile: model.Profile) -> PlausibilitySpec:
    """Return the thresholds common to all sensors; their names there have no unit."""
    names = [name.removesuffix("_s") for name in PlausibilitySpec._fields]
    return PlausibilitySpec._make(getattr(profile.plausibility, name) for name in names)


def _watched(signals: Signals, board: model.Board, spec: BoardSpec) -> WatchedSpec:
    """Return the board's sensors that measure a motor or have a limit."""
    profile, names = signals.profile, signals.vocabulary.numbers
    numbers = {place: number for place, number, _ in spec.channels}
    slots = {slot.name: (index, slot) for index, slot in enumerate(profile.slots)}
    found = []
    for place, number in sorted(numbers.items()):
        channel = board.channels[place]
        index, slot = slots.get(channel.slot or "", (-1, None))
        senses, motor = channel.senses or "", profile.motors[slot.motor] if slot else None
        watch = WatchSpec(number, names[number], (number, *_resting_on(spec, number)), slot=index)
        for bounds, most in profile.plausibility.limits(senses, motor):
            if bounds == "value":
                watch = watch._replace(low=max(watch.low, -most), high=min(watch.high, most))
            else:
                watch = watch._replace(rate=min(watch.rate, most))
        if slot and senses == "angle":
            watch = _angle_limits(profile, board, watch, slot, numbers)
        elif channel.convert:
            watch = watch._replace(unit=unit_of(signals.scales[channel.convert][1]))
        if slot or watch.high < inf or watch.rate < inf:
            found.append(watch._replace(of=slot.drives if slot else ""))
    return WatchedSpec(tuple(found))


def _angle_limits(
    profile: model.Profile,
    board: model.Board,
    watch: WatchSpec,
    slot: model.Slot,
    numbers: Mapping[int, int],
) -> WatchSpec:
    """Return the limits of the angle of a joint, a wheel or a roll joint."""
    own, motor = profile.plausibility, profile.motors[slot.motor]
    slack = own.joint_slack if watch.rate < inf else 0.0
    watch = watch._replace(unit="deg", per_unit=_DEGREE, slack=slack)
    if slot.wheel is not None:
        # The wheels of a falling robot may turn: that must be reported at once.
        return watch._replace(slack=own.wheel_slack, moved=own.wheel_moved)
    stop = next((j.end_stop for j in profile.body.joints if j.name == slot.joint), None)
    if stop is None:
        return watch
    most = stop + own.beyond_stop
    low, high = max(watch.low, -most), min(watch.high, most)
    watch = watch._replace(low=low, high=high, joint=True, moved=own.joint_moved)
    torque = _of_motor("torque", board.channels, slot, numbers)
    if torque >= 0 and motor.stiffness is not None and motor.no_load_speed is not None:
        # What others push shows as torque, so that the motor's own speed is the limit.
        rate = min(watch.rate, motor.no_load_speed)
        watch = watch._replace(torque=torque, stiffness=motor.stiffness, rate=rate)
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
    return tuple(dict.fromkeys(each.target for each in spec.derived if number in each.sources))


def resolve_traction(signals: Signals, boards: Mapping[int, BoardSpec]) -> TractionSpec | None:
    """Return what the robot's signals of traction are made of; None where it has none."""
    profile = signals.profile
    wanted = {n: d for n, d in profile.derived.items() if isinstance(d, kinds.TractionSignal)}
    if not wanted:
        return None
    body = profile.body
    modules = [link.module for link in body.links]
    torques = {joint.wheel: joint.torque for joint in body.joints}
    on_boards = [next((b for b in boards.values() if w in b.wheels), None) for w in signals.wheels]
    wheels = tuple(
        _wheel_traction(signals, wheel, board, wanted)
        for wheel, board in zip(signals.wheels, on_boards, strict=True)
    )
    measured = _measured_speed(signals, wanted)
    mounts = [board.module if board else "" for board in on_boards]
    spec = TractionSpec(
        wheels,
        wheels[-1].board,
        tuple(signals.index(torques.get(wheel.name)) for wheel in body.wheels),
        tuple(modules.index(module) if module in modules else 0 for module in mounts),
        _masses_kg(body),
        measured=signals.index(measured),
        averages_s=profile.outside[measured].averages if measured else 0.0,
        # A frame is late by one way of the link, its echo by both.
        delay_s=profile.link.echo_delay,
    )
    spec = _with_shared(signals, spec, wanted)
    _check_traction(signals, spec, wanted)
    return spec


def _masses_kg(body: Body) -> tuple[float, ...]:
    """Return the mass of each wheel with half of its links."""
    masses = [wheel.mass for wheel in body.wheels]
    for number, link in enumerate(body.links):
        masses[number] += link.mass / 2
        masses[number + 1] += link.mass / 2
    return tuple(masses)


def _wheel_traction(
    signals: Signals,
    wheel: WheelSpec,
    board: BoardSpec | None,
    wanted: Mapping[str, kinds.TractionSignal],
) -> WheelTraction:
    """Return what the signals of one wheel are made of."""
    profile = signals.profile
    slot = profile.slots[wheel.slot]
    motor = profile.motors[slot.motor]
    name, numbers = profile.body.wheels[wheel.place].name, signals.vocabulary.numbers
    own = WheelTraction(
        wheel.place,
        board.position if board else -1,
        wheel.slot,
        wheel.speed,
        signals.derived_by(kinds.TorqueOf, slot=slot.name),
        wheel.metres_per_rad,
        motor.stall_torque or 0.0,
        motor.no_load_speed or inf,
        profile.simulation.tyre.rolling_resistance,
        slip_speed=signals.derived_by(kinds.SlipSpeedOf, slip_speed_of=name),
        normal_force=signals.derived_by(kinds.NormalForceOf, normal_force_of=name),
        friction_used=signals.derived_by(kinds.FrictionUsedOf, friction_used_of=name),
    )
    for signal, derived in wanted.items():
        at = numbers.index(signal)
        match derived:
            case kinds.SlipOf(slip_of=of, unknown_below=limit) if of == name:
                own = own._replace(slip=at, unknown_below_m_s=limit)
            case kinds.FrictionOf(friction_of=of, slip_above=above, steady=steady) if of == name:
                own = own._replace(friction=at, slip_above_m_s=above, steady_s=steady)
            case _:
                pass
    return own


def _with_shared(
    signals: Signals, spec: TractionSpec, wanted: Mapping[str, kinds.TractionSignal]
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
                known = tuple(signals.index(source) for source in sources)
                spec = spec._replace(least=(*spec.least, (names.index(name), known)))
            case _:
                pass
    return spec


def _measured_speed(signals: Signals, wanted: Mapping[str, kinds.TractionSignal]) -> str | None:
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


def _check_traction(
    signals: Signals, spec: TractionSpec, wanted: Mapping[str, kinds.TractionSignal]
) -> None:
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
