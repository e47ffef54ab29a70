"""Rules about references that resolve and are wrong: each names what it is for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.core.documents import Path
from pirate_sm.core.expressions import NumberType
from pirate_sm.core.models import done_criteria
from pirate_sm.core.models import signals as kinds
from pirate_sm.core.units import ACCELERATION, ANGLE, CURRENT, TORQUE

_MOTORS = {"wheel": "geared", "joint": "sprung_worm", "roll": "position"}
"""The kind of motor that drives each kind of thing."""

_UNITS = {"angle": ANGLE, "torque": TORQUE, "current": CURRENT} | dict.fromkeys(
    ("acc_x", "acc_y", "acc_z"), ACCELERATION
)
"""The dimension of what a channel senses."""

_SENSES = {str(NumberType(CURRENT)): "current", str(NumberType(TORQUE)): "torque"}
"""What a channel with this kind of number senses."""


class _Wrong(NamedTuple):
    """A wrong reference."""

    path: Path
    message: str
    fix: str
    severity: Severity | None = None
    key: bool = False


_Rule: TypeAlias = Callable[[RobotView], Iterator[_Wrong]]


class _Measured(NamedTuple):
    """A signal that the body needs, with the quantity, the thing that has it, and its path."""

    signal: str
    sense: str
    kind: str
    thing: str
    path: Path


def references(view: RobotView) -> Iterator[Finding]:
    """Yield references to things of other wheels, joints, parts or boards; one for each thing."""
    yield from found_by((*OF_PROFILE, _apex_references, _loads, _denials), view)


def found_by(rules: Sequence[_Rule], view: RobotView) -> Iterator[Finding]:
    """Yield what some of these rules find, such as `OF_PROFILE`."""
    said: set[Path] = set()
    for rule in rules:
        for path, message, fix, severity, key in rule(view):
            thing = path[: {"boards": 4, "body": 3}.get(str(path[0]), 2)]
            if thing not in said:
                said.add(thing)
                yield view.at(path, "robot.reference", message, fix=fix, severity=severity, key=key)


def _chain(view: RobotView) -> Iterator[_Wrong]:
    """Yield parts and joints without a place in the chain, or without a slot."""
    body = view.profile.body
    wheels = {wheel.name: wheel for wheel in body.wheels}
    for number, wheel in enumerate(body.wheels[1:], start=1):
        before = [each.part for each in body.wheels[:number]]
        if wheel.part in before and before[-1] != wheel.part:
            message = f"'{wheel.name}' is of the part '{wheel.part}', which ends before it"
            fix = f"write `part: {before[-1]}`: the wheels of a part follow one another"
            yield _Wrong(("body", "wheels", number, "part"), message, fix)
    sat: dict[str, str] = {}
    for number, joint in enumerate(body.joints):
        path: Path = ("body", "joints", number)
        if joint.wheel in sat:
            message = f"'{joint.name}' and '{sat[joint.wheel]}' both sit at '{joint.wheel}'"
            fix = "a wheel has one joint: name another wheel, or delete this joint"
            yield _Wrong((*path, "wheel"), message, fix)
        elif joint.part != wheels[joint.wheel].part:
            own = wheels[joint.wheel].part
            message = f"'{joint.name}' sits at '{joint.wheel}', which is of the part '{own}'"
            yield _Wrong((*path, "part"), message, f"write `part: {own}`")
        sat.setdefault(joint.wheel, joint.name)
        if joint.name not in view.slot_of:
            fix = f"give a board a slot with `joint: {joint.name}`; a node that nothing bends has"
            message = f"no slot drives '{joint.name}'"
            severity = _passive(view, joint.name)
            yield _Wrong((*path, "name"), message, f"{fix} no joint", severity)
    modules = [link.module for link in body.links]
    for number, link in enumerate(body.links):
        path = ("body", "links", number)
        if link.module in modules[:number]:
            message = f"the module '{link.module}' is a link already"
            fix = "each link is a module of its own: give it another name"
            yield _Wrong((*path, "module"), message, fix)
        if link.roll and link.roll not in view.slot_of:
            fix = f"give a board a slot with `roll: {link.roll}`"
            message = f"no slot drives '{link.roll}'"
            yield _Wrong((*path, "roll"), message, fix, _passive(view, link.roll))


def _passive(view: RobotView, angle: str) -> Severity | None:
    """Return how bad it is that nothing drives a joint: one that is measured may be passive."""
    return Severity.WARNING if angle in view.channels else None


def _apex_references(view: RobotView) -> Iterator[_Wrong]:
    """Yield parts whose V is at a joint of another part, or where one of its legs is not theirs."""
    body = view.profile.body
    names = [wheel.name for wheel in body.wheels]
    for part in body.parts:
        own = [wheel.name for wheel in body.wheels if wheel.part == part]
        joints = [each for each in body.joints if each.part == part]
        whole = {
            each.name
            for each in joints
            if set(names[names.index(each.wheel) - 1 : names.index(each.wheel) + 2]) <= set(own)
        }
        usual = whole or {each.name for each in joints}
        apex = body.parts[part].apex
        if apex not in usual:
            message = f"the V of '{part}' needs its tip at a joint of it, between two of its wheels"
            valid = " or ".join(f"`apex: {each}`" for each in sorted(usual))
            fix = f"write {valid}" if valid else f"give '{part}' a joint"
            own_joint = apex in {each.name for each in joints}  # unusual, yet nothing moves wrongly
            severity = Severity.WARNING if own_joint else None
            yield _Wrong(("body", "parts", part, "apex"), message, fix, severity)


def _needed(view: RobotView) -> Iterator[_Measured]:
    """Yield the signals of the body that a board measures."""
    body = view.profile.body
    for number, wheel in enumerate(body.wheels):
        path: Path = ("body", "wheels", number, "angle")
        yield _Measured(wheel.angle, "angle", "wheel", wheel.name, path)
    for number, joint in enumerate(body.joints):
        path = ("body", "joints", number)
        yield _Measured(joint.name, "angle", "joint", joint.name, (*path, "name"))
        if joint.torque:
            yield _Measured(joint.torque, "torque", "joint", joint.name, (*path, "torque"))
    for number, link in enumerate(body.links):
        if link.roll:
            path = ("body", "links", number, "roll")
            yield _Measured(link.roll, "angle", "roll", link.roll, path)


def _measured(view: RobotView) -> Iterator[_Wrong]:
    """Yield signals of the body that are measured at something else, or shared."""
    needed, drives, slots = list(_needed(view)), view.drives, view.slot_of
    owners: dict[str, str] = {}
    for each in needed:
        other = owners.setdefault(each.signal, each.thing)
        channel, at = view.channels.get(each.signal, (None, ()))
        if channel is None:
            if fault := _not_measured(view, each):
                yield _Wrong(each.path, fault, _own(view, each))
            continue
        of = drives.get(channel.slot or "", each.thing)
        board = view.profile.boards[int(at[1])]
        if not (board.fitted and board.channels_fitted):
            message = f"board {board.id}, which would measure '{each.signal}', is not fitted"
            yield _Wrong(each.path, message, _own(view, each), Severity.WARNING)
        elif channel.senses not in (each.sense, None):
            message = f"'{each.signal}' is the {channel.senses} of '{of}'"
            message += f", not the {each.sense} of '{each.thing}'"
            yield _Wrong(each.path, message, _own(view, each))
        elif of != each.thing and any((of, each.signal) == (n.thing, n.signal) for n in needed):
            message = f"'{each.signal}' is the {each.sense} of '{of}', not of '{each.thing}'"
            yield _Wrong(each.path, message, _own(view, each))
        elif of != each.thing:
            message = f"'{each.signal}' is the {each.sense} of '{each.thing}', and '{channel.slot}'"
            message += f" drives '{of}'" if of else " drives nothing that has one"
            fix = f"write `slot: {slots[each.thing]}`" if each.thing in slots else ""
            yield _Wrong((*at, "slot"), message, fix)
        elif other != each.thing:
            message = f"'{each.signal}' is the {each.sense} of '{other}' already"
            yield _Wrong(each.path, message, _own(view, each))


def _not_measured(view: RobotView, each: _Measured) -> str:
    """Return why a signal that no channel has is not the one that the body needs."""
    derived = view.profile.derived.get(each.signal)
    if each.sense == "torque" and isinstance(derived, kinds.TorqueOf):
        of = view.drives.get(derived.slot)
        return f"'{each.signal}' is the torque of '{of}'" if of != each.thing else ""
    return f"no board measures '{each.signal}', the {each.sense} of '{each.thing}'"


def _own(view: RobotView, each: _Measured) -> str:
    """Return what to write for the signal of a thing: its own one, or a channel to be added."""
    slot, key = view.slot_of.get(each.thing, ""), each.path[-1]
    for signal, (channel, _) in view.channels.items():
        if slot and (channel.slot, channel.senses) == (slot, each.sense):
            return f"write `{key}: {signal}`"
    return f"add a channel of its own to a board, `senses: {each.sense}, slot: {slot or '…'}`"


def _speeds(view: RobotView) -> Iterator[_Wrong]:
    """Yield speeds of wheels that are those of other wheels."""
    derived, drives = view.profile.derived, view.drives
    rates = {own.rate_of: name for name, own in derived.items() if isinstance(own, kinds.RateOf)}
    for number, wheel in enumerate(view.profile.body.wheels):
        own, path = derived.get(wheel.speed), ("body", "wheels", number, "speed")
        channel, _ = view.channels.get(wheel.speed, (None, ()))
        if isinstance(own, kinds.RateOf) and own.rate_of != wheel.angle:
            message = f"'{wheel.speed}' is the rate of '{own.rate_of}', and the angle of"
            message += f" '{wheel.name}' is '{wheel.angle}'"
            if wheel.angle in rates:
                fix = f"write `speed: {rates[wheel.angle]}`"
                yield _Wrong(path, message, fix)
            else:
                at = ("derived", wheel.speed, "rate_of")
                yield _Wrong(at, message, f"write `rate_of: {wheel.angle}`")
        elif channel and (of := drives.get(channel.slot or "")) and of != wheel.name:
            message = f"'{wheel.speed}' is measured at '{of}'"
            yield _Wrong(path, message, f"name a signal of '{wheel.name}'")
        elif not isinstance(own, kinds.RateOf) and not channel:
            message = f"'{wheel.speed}' is not the speed of a wheel"
            yield _Wrong(path, message, f"derive one, `{{rate_of: {wheel.angle}}}`")


def _derived(view: RobotView) -> Iterator[_Wrong]:
    """Yield derived signals that mix things up, or that are there already."""
    known: dict[str, str] = {}
    axes = ["acc_x", "acc_y", "acc_z"]
    for name, own in view.profile.derived.items():
        path: Path = ("derived", name)
        other = known.setdefault(f"{type(own).__name__} {own.model_dump()}", name)
        if isinstance(own, kinds.TorqueOf):
            channel, _ = view.channels.get(own.torque_of, (None, ()))
            if channel and channel.slot not in (own.slot, None):
                message = f"'{own.torque_of}' is the current of '{channel.slot}'"
                fix = f"write `slot: {channel.slot}`, or name the current of '{own.slot}'"
                yield _Wrong((*path, "slot"), message, fix)
        elif own.OF == "axes":
            key = own.key()
            found = [view.channels.get(each, (None, ())) for each in own.sources]
            senses = [channel.senses if channel else None for channel, _ in found]
            apart = len({at[:2] for _, at in found}) > 1
            if apart or any(
                each not in (axis, None) for each, axis in zip(senses, axes, strict=True)
            ):
                message = f"`{key}` takes x, y and z of one accelerometer, in this order"
                yield _Wrong((*path, key), message, "name its signals so")
        elif isinstance(own, kinds.LeastOf):
            of = {type(view.profile.derived.get(each)) for each in own.least_of}
            if len(of) > 1:
                message = "the least is taken of signals of one kind, and these are of several"
                fix = "name signals that are derived in the same way"
                yield _Wrong((*path, "least_of"), message, fix)
        if other != name:
            message = f"'{name}' is the same signal as '{other}'"
            fix = "correct what it is of, or delete it"
            yield _Wrong(path, message, fix, severity=Severity.WARNING, key=True)


def _channels(view: RobotView) -> Iterator[_Wrong]:
    """Yield channels whose unit is not that of what they sense, or that sense it a second time."""
    types = view.loaded.normal.vocabulary.types
    boards = enumerate(view.profile.boards)
    own: dict[object, set[str]] = {n: {slot.name for slot in each.slots} for n, each in boards}
    for number, board in enumerate(view.profile.boards):
        names = [channel.name for channel in board.channels]
        for place, name in enumerate(names):
            if name in names[:place]:
                at: Path = ("boards", number, "channels", place, "name")
                message = f"two channels of this board are named '{name}'"
                yield _Wrong(at, message, "give each its own name")
    known: dict[tuple[str, str], str] = {}
    for signal, (channel, path) in view.channels.items():
        needed, kind = _UNITS.get(channel.senses or ""), types[signal]
        if needed and kind != NumberType(needed):
            message = f"'{signal}' senses `{channel.senses}`, {NumberType(needed)}, and is {kind}"
            fix = f"`convert` it to {NumberType(needed)}"
            yield _Wrong((*path, "convert"), message, fix)
        if channel.senses and _SENSES.get(str(kind), channel.senses) != channel.senses:
            message = f"'{signal}' senses `{channel.senses}`, and is {kind}"
            fix = f"write `senses: {_SENSES[str(kind)]}`"
            yield _Wrong((*path, "senses"), message, fix)
        if channel.senses == "current" and channel.slot not in own[path[1]]:
            message = f"the current of '{channel.slot}' is measured where it is driven, and"
            message += " another board drives it"
            fix = "name a slot of this board, or move the channel to the other one"
            yield _Wrong((*path, "slot"), message, fix, Severity.WARNING)
        what = channel.senses or "", channel.slot or ""
        other = known.setdefault(what, signal) if all(what) else signal
        if other != signal:
            message = f"'{other}' is the {channel.senses} of '{channel.slot}' already"
            fix = f"name the slot that '{signal}' is measured at"
            yield _Wrong((*path, "slot"), message, fix, severity=Severity.WARNING)


def _motors(view: RobotView) -> Iterator[_Wrong]:
    """Yield slots with a motor that is made for something else."""
    for number, (slot, path) in enumerate(view.slots):
        thing = next((kind for kind in _MOTORS if getattr(slot, kind)), "")
        kind = view.motor(number).kind
        if (_MOTORS[thing] != kind) if thing else (kind in _MOTORS.values()):
            names = [n for n, m in view.profile.motors.items() if m.kind == _MOTORS.get(thing)]
            drives = f"a {thing}" if thing else "no wheel and no joint"
            message = f"'{slot.name}' drives {drives}, with a motor of the kind {kind}"
            fix = f"write `motor: {names[0]}`" if names else "name a motor of another kind"
            if not thing:
                fix = "name the `wheel`, `joint` or `roll` that it drives, or another motor"
            yield _Wrong((*path, "motor"), message, fix, severity=Severity.WARNING)


_NAMES = {"joints", "loaded", "slots", "signals", "zero", "denies"}
"""The keys of lists of signals, joints, slots and parts, in which each is once, as in those of what
a signal is derived from."""


def _lists(view: RobotView) -> Iterator[_Wrong]:
    """Yield names that a list has twice."""
    stack: list[tuple[Path, object]] = [((), view.loaded.documents[0].data)]
    while stack:
        path, value = stack.pop()
        if isinstance(value, dict):
            stack += [((*path, key), each) for key, each in value.items()]
        elif isinstance(value, list):
            stack += [((*path, place), each) for place, each in enumerate(value)]
            seen = set[str]()
            once = path[0] == "derived" or path[-1] in _NAMES
            for place, each in enumerate(value if once else ()):
                if isinstance(each, str):
                    if each in seen:
                        message, fix = f"'{each}' is listed twice", "write each name once"
                        yield _Wrong((*path, place), message, fix, Severity.WARNING)
                    seen.add(each)


def _loads(view: RobotView) -> Iterator[_Wrong]:
    """Yield joints that are to show a clamp of another part."""
    part_of = {joint.name: joint.part for joint in view.profile.body.joints}
    robot = view.loaded.normal
    for part, held in view.profile.seen.parts.items():
        for place, name in enumerate(held.loaded):
            if part_of.get(name) != part:
                message = f"'{name}' does not show whether '{part}' holds: it is of another part"
                fix = f"name joints of '{part}'"
                yield _Wrong(("seen", "parts", part, "loaded", place), message, fix)
    for number, command in enumerate(robot.commands):
        done = view.profile.commands[command.name].done
        moves = view.moves(number)
        clamped = {robot.parts[p] for a, b in moves for p in robot.held[b] - robot.held[a]}
        if not isinstance(done, done_criteria.Stalled) or not clamped & {
            part_of[each] for each in done.loaded
        }:
            continue  # reported as a clamp without a sign
        for place, name in enumerate(done.joints):
            if part_of.get(name) not in clamped:
                message = f"{command.name} makes {' and '.join(sorted(clamped))} hold, and"
                message += f" '{name}' is of another part"
                path = ("commands", command.name, "done", "joints", place)
                yield _Wrong(path, message, "name joints of the part that it clamps")


def _denials(view: RobotView) -> Iterator[_Wrong]:
    """Yield faults that deny the clamp of a part by signals that are all of other parts."""
    parts, rules = _parts_of_signals(view), iter(view.loaded.normal.faults)
    for number, fault in enumerate(view.profile.faults):
        written_out = [next(rules) for _ in fault.for_each or (None,)]
        seen = {parts[name] for rule in written_out for name in rule.when.names if name in parts}
        for place, part in enumerate(fault.denies):
            if seen and part not in seen:
                message = f"{fault.code} shows that '{part}' does not hold by signals of"
                message += f" '{min(seen)}' alone"
                fix = f"write `denies: [{min(seen)}]`, or ask for signals of '{part}'"
                path = ("faults", number, "denies", place)
                yield _Wrong(path, message, fix, Severity.WARNING)


def _parts_of_signals(view: RobotView) -> dict[str, str]:
    """Return the part of each signal that is measured at one of its wheels or joints."""
    body = view.profile.body
    things = {wheel.name: wheel.part for wheel in body.wheels}
    things |= {joint.name: joint.part for joint in body.joints}
    drives = view.drives
    found = {
        signal: things[drives[channel.slot]]
        for signal, (channel, _) in view.channels.items()
        if channel.slot and drives[channel.slot] in things
    }
    for name, own in view.profile.derived.items():
        of = {each if own.OF == "parts" else found.get(each, "") for each in own.sources}
        if own.OF == "wheels":  # a signal may have the name of a wheel
            continue
        if len(of) == 1 and any(of):
            (found[name],) = of
    return found


OF_PROFILE = (_chain, _measured, _speeds, _derived, _channels, _motors, _lists)
"""Those that a robot with other faults can be asked."""
