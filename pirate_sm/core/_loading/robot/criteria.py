"""Make of each kind of criterion, and of each seen state, what sensors must show for it.

Names become indexes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import copysign, degrees, inf
from typing import assert_never

from pirate_sm.core._engine.robot.actuation_spec import SlotSpec, StageSpec, Write
from pirate_sm.core._engine.robot.criteria import (
    AngleSet,
    Bound,
    CriterionSpec,
    DarkSpec,
    Demand,
    HeldSpec,
    JointsArrived,
    LoadedJoint,
    SeenSpec,
    Sight,
    Sign,
    TorqueBorne,
    WheelTurning,
    near,
    only,
    standing,
)
from pirate_sm.core._engine.robot.robot_spec import Actuation, ChartTable
from pirate_sm.core._expressions import NumberType
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model.robot import done_criteria as model
from pirate_sm.core._model.robot import seen_states as sight
from pirate_sm.core._model.robot.signals import DiameterOf, RateOf
from pirate_sm.core.units import Quantity, describe

# --- criteria ---------------------------------------------------------------------------------


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
            for name, stop in done.stops(signals.profile.body):
                yield only(Bound(signals.number(name, path), "<", stop))
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


# --- seen states, for one polarity ------------------------------------------------------------


def resolve_sight(
    table: ChartTable, slots: tuple[SlotSpec, ...], actuation: Actuation, signals: Signals
) -> Sight:
    """Return the criteria that confirm or contradict each state and part; report their faults."""
    profile, problems = signals.profile, signals.problems
    seen = profile.seen
    parts, regions = tuple(profile.body.parts), table.regions
    _check_names(seen.parts, parts, ("seen", "parts"), "part", problems)
    _check_names(seen.states, regions, ("seen", "states"), "region", problems)
    states: list[Mapping[str, SeenSpec]] = []
    for number, region in enumerate(regions):
        given = seen.states.get(region, {})
        path: Path = ("seen", "states", region)
        _check_names(given, table.states[number], path, "state", problems)
        resolver = _States(slots, actuation[number], signals)
        found = {
            name: resolver.state(how, name, (*path, name))
            for name, how in given.items()
            if name in table.states[number]
        }
        states.append({name: spec for name, spec in found.items() if spec is not None})
    held = tuple(
        _part(name, seen.parts[name], actuation, signals) if name in seen.parts else None
        for name in parts
    )
    return Sight(seen.within, held, tuple(states), _dark(signals))


def _dark(signals: Signals) -> DarkSpec:
    """Return what is compared besides when a run that was cut off is resumed."""
    profile, seen = signals.profile, signals.profile.seen
    absolute = {wheel.angle for wheel in profile.body.wheels if wheel.absolute}
    motors = [profile.motors[slot.motor] for slot in profile.slots if slot.wheel is not None]
    speeds = [getattr(motor, "no_load_speed", None) or inf for motor in motors]
    return DarkSpec(
        frozenset(
            wheel.place
            for wheel in signals.wheels
            if signals.vocabulary.numbers[wheel.angle] in absolute
        ),
        max(speeds, default=0.0) * profile.body.wheel_radius,
        seen.wheels_agree,
        seen.tilt,
        seen.joint_off,
    )


def _check_names(
    given: Mapping[str, object], valid: tuple[str, ...], path: Path, kind: str, problems: Problems
) -> None:
    for name in given.keys() - set(valid):
        problems.add_unknown("robot.seen", (*path, name), kind, name, valid, key=True)


def _part(
    name: str, how: sight.HeldPart, actuation: Actuation, signals: Signals
) -> HeldSpec | None:
    path: Path = ("seen", "parts", name)
    profile, problems = signals.profile, signals.problems
    body = profile.body
    apex, diameter = body.apex_of(name), profile.derived_by(DiameterOf, diameter_of=name)
    if not diameter:
        message = f"whether '{name}' shows the pipe needs a derived signal {{diameter_of: {name}}}"
        problems.add("robot.seen", path, message, key=True)
    if how.span >= how.span_off:
        problems.add("robot.seen", (*path, "span_off"), "`span_off` must be larger than `span`")
    joints = [
        _joint(joint, how, actuation, signals, (*path, "loaded", number))
        for number, joint in enumerate(how.loaded)
    ]
    if any(joint is not None and how.slack > joint.needed_nm for joint in joints):
        key = "share" if how.torque is None else "torque"
        problems.add("robot.seen", (*path, "slack"), f"`slack` cannot be more than the `{key}`")
    if apex is None or not diameter:
        return None
    return HeldSpec(
        tuple(joint for joint in joints if joint is not None),
        how.slack,
        how.still,
        signals.number(diameter, path),
        signals.number(apex.name, path),
        apex.end_stop - how.end_stop,
        how.span,
        how.span_off,
        how.for_s,
        inf if how.settled is None else how.settled,
    )


def _joint(
    name: str, how: sight.HeldPart, actuation: Actuation, signals: Signals, path: Path
) -> LoadedJoint | None:
    profile, problems = signals.profile, signals.problems
    joint = next((each for each in profile.body.joints if each.name == name), None)
    joints = {each.name for each in profile.body.joints}
    if any(slot.joint is not None and slot.joint not in joints for slot in profile.slots):
        return None  # a slot without a joint is reported already
    slot = next((n for n, each in enumerate(profile.slots) if each.joint == name), -1)
    if joint is None or joint.torque is None or slot < 0:
        names = [each.name for each in profile.body.joints if each.torque is not None]
        message = f"'{name}' is not a driven joint with a torque signal"
        problems.add_unknown("robot.seen", path, "", name, names, message=message)
        return None
    rate = rate_of(name, signals, "robot.seen", path)
    load = resolve_load(how, name, signals.number(joint.torque, path), signals, path)
    writes = (w for states in actuation for each in states.values() for w in each[-1])
    duty = max((abs(w.value) for w in writes if w.slot == slot and w.how == "set"), default=0.0)
    needed_nm = max(load.full_nm * (duty or 1.0), load.least_nm)
    least_nm = max(how.slack, how.at_least or 0.0)
    return LoadedJoint(slot, load.torque, rate, needed_nm, least_nm)


def angles_shown(
    targets: tuple[tuple[int, float], ...], within: float, beyond: float, for_s: float
) -> SeenSpec:
    """Return that angles, by their number indexes, are near their setpoints."""
    far = f"{degrees(beyond):z.0f} deg"
    limit = f"within {degrees(within):z.0f} deg" + (f", off beyond {far}" if beyond < inf else "")
    signs = tuple(
        Sign(
            near(angle, target, beyond)._replace(or_unknown=True),
            "deg",
            f"not {degrees(target):z.0f} deg, limit {far} off",
            f"{degrees(target):z.0f} deg {limit}",
        )
        for angle, target in targets
    )
    needs = tuple(only(near(angle, target, within)) for angle, target in targets)
    return SeenSpec("angles", needs, signs, for_s)


def wheels_stand(speeds: tuple[int, ...], below: float, for_s: float) -> SeenSpec:
    """Return that wheels, by the number indexes of their speeds, stand still."""
    limit = f"{below:g} rad/s"
    signs = tuple(
        Sign(Bound(each, "<", below, or_unknown=True), "rad/s", f"limit {limit}", f"below {limit}")
        for each in speeds
    )
    return SeenSpec("stopped", standing(speeds, below), signs, for_s)


def wheels_driven(wheels: tuple[tuple[int, float], ...], above: float, for_s: float) -> SeenSpec:
    """Return that no wheel turns the other way: each has its speed's number index and its way.

    Wheels that stand still or turn as commanded count as driven only after a command.
    """
    limit = f"not above {above:g} rad/s the other way"
    signs = tuple(
        Sign(Bound(speed, "<=", above, way=-way, or_unknown=True), "rad/s", "the other way", limit)
        for speed, way in wheels
    )
    return SeenSpec("turning", None, signs, for_s)


class _States:
    """Resolves the states of one region."""

    def __init__(
        self,
        slots: tuple[SlotSpec, ...],
        actuation: Mapping[str, tuple[StageSpec, ...]],
        signals: Signals,
    ) -> None:
        self._slots = slots
        self._actuation = actuation
        self._speeds = {wheel.slot: wheel.speed for wheel in signals.wheels}
        self._problems, self._signals = signals.problems, signals

    def state(self, how: sight.SeenState, name: str, path: Path) -> SeenSpec | None:
        """Return the criterion of the state; None if no sensor can show it."""
        match how:
            case sight.Angles():
                beyond = inf if how.beyond is None else how.beyond
                if beyond <= how.within:
                    message = "`beyond` must be larger than `within`"
                    self._problems.add("robot.seen", (*path, "beyond"), message)
                if not self._sets_angle(name):
                    self._need((), path, f"{name} sets no angle")
                return angles_shown(self._targets(name), how.within, beyond, how.for_s)
            case sight.StandingWheels():
                still = tuple(speed for speed, way in self._wheels(name) if way == 0)
                self._need(still, path, f"{name} stops no wheel")
                return wheels_stand(still, how.below, how.for_s)
            case sight.TurningWheels():
                driven = tuple((speed, way) for speed, way in self._wheels(name) if way)
                self._need(driven, path, f"{name} drives no wheel")
                return wheels_driven(driven, turning_rad_s(how, self._signals, path), how.for_s)
            case sight.AcceptedState():
                return SeenSpec(how.kind)
            case sight.Implied():
                return SeenSpec(how.kind, needs=())
            case sight.Unknown():
                return None

    def _need(self, found: tuple[object, ...], path: Path, message: str) -> None:
        if not found:
            self._problems.add("robot.seen", (*path, "kind"), message)

    def _sets_angle(self, name: str) -> bool:
        return any(self._is_angle(write) for stage in self._actuation[name] for write in stage)

    def _is_angle(self, write: Write) -> bool:
        unit = self._slots[write.slot].unit
        return write.how == "seek" or (write.how == "set" and unit == "angle")

    def _targets(self, name: str) -> tuple[tuple[int, float], ...]:
        """Return the number index and setpoint of each angle, from the first stage that sets it."""
        found: dict[int, float] = {}
        for stage in self._actuation[name]:
            for write in stage:
                angle = self._slots[write.slot].angle
                if self._is_angle(write) and angle >= 0:
                    found.setdefault(angle, write.value)
        return tuple(found.items())

    def _wheels(self, name: str) -> list[tuple[int, float]]:
        """Return the number index of each wheel's speed, and its direction: 1, -1 or 0."""
        return [
            (self._speeds[write.slot], copysign(1.0, write.value) if write.value else 0.0)
            for write in self._actuation[name][-1]
            if write.slot in self._speeds and write.how in ("set", "turn")
        ]
