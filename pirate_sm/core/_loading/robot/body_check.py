"""Check the consistency of a profile: its chain, motors, sensors and known defects."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import get_args

from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._model.robot import profile as model
from pirate_sm.core._model.robot.body import Body
from pirate_sm.core._model.robot.defects import Defect

MOTOR_NEEDS = {
    "sprung_worm": ("stall_torque", "stall_current", "no_load_speed", "stiffness"),
    "geared": ("stall_torque", "stall_current", "no_load_speed", "hold_torque", "dead_drag"),
    "position": ("no_load_speed",),
    "light": (),
    "none": (),
}
"""The required keys of each kind of motor."""

_DIVISORS = ("stall_torque", "stall_current", "no_load_speed", "stiffness")
"""Keys of motors by which the program divides, in any kind of motor."""

DEFECT_NEEDS = {
    "dead_wheel": ("wheels",),
    "stiff_joint": ("joint",),
    "sensor_spike": ("raw",),
    "zero_jump": ("raw",),
    "lost_messages": ("share",),
    "silent_boards": ("boards",),
}
"""The required keys of each kind of defect."""


def check_body(profile: model.Profile, problems: Problems) -> None:
    """Report unknown names, and a wrong number of links or motors."""
    _check_chain(profile.body, problems)
    _check_joints(profile.body, problems)
    _check_motors(profile, problems)
    _check_boards(profile, problems)
    _check_slots(profile, problems)
    _check_channels(profile, problems)
    _check_safe_state(profile, problems)
    _check_detector(profile, problems)
    for name, defect in profile.simulation.defects.items():
        _check_defect(profile, defect, ("simulation", "defects", name), problems)


def _check_chain(body: Body, problems: Problems) -> None:
    needed = len(body.wheels) - 1
    if len(body.links) != needed:
        problems.add(
            "robot.link",
            ("body", "links"),
            f"{len(body.wheels)} wheels are joined by {needed} links, got {len(body.links)}",
            key=True,
        )
    _refuse_twice([wheel.name for wheel in body.wheels], ("body", "wheels"), problems)
    _refuse_twice([joint.name for joint in body.joints], ("body", "joints"), problems)
    rolls = [number for number, link in enumerate(body.links) if link.roll is not None]
    for number in rolls[1:]:
        problems.add("robot.link", ("body", "links", number, "roll"), "only one link can roll")
    _check_parts(body, problems)


def _check_parts(body: Body, problems: Problems) -> None:
    parts = {
        "wheels": [wheel.part for wheel in body.wheels],
        "joints": [joint.part for joint in body.joints],
    }
    for section, names in parts.items():
        for number, name in enumerate(names):
            _must_be(name, body.parts, "part", ("body", section, number, "part"), problems)


def _check_joints(body: Body, problems: Problems) -> None:
    names = [wheel.name for wheel in body.wheels]
    for number, joint in enumerate(body.joints):
        path: Path = ("body", "joints", number, "wheel")
        _must_be(joint.wheel, names, "wheel", path, problems)
        if joint.wheel in (names[0], names[-1]):
            message = f"'{joint.wheel}' is an end of the chain: a joint is between two links"
            problems.add("robot.joint", path, message)


def _check_motors(profile: model.Profile, problems: Problems) -> None:
    for slot, at in _slots(profile):
        _must_be(slot.motor, profile.motors, "motor", (*at, "motor"), problems)
    used = {slot.motor for slot in profile.slots}
    for name, motor in profile.motors.items():
        path: Path = ("motors", name)
        needed = MOTOR_NEEDS[motor.kind] if name in used else ()
        for key in needed:
            if getattr(motor, key) is None:
                message = f"a motor of the kind {motor.kind} needs `{key}`"
                problems.add("robot.motor", path, message, key=True)
        for key in dict.fromkeys((*needed, *_DIVISORS)):
            value = getattr(motor, key)
            if value is not None and value <= 0:
                problems.add("robot.motor", (*path, key), f"`{key}` must be more than 0")


def _slots(profile: model.Profile) -> Iterator[tuple[model.Slot, Path]]:
    for number, board in enumerate(profile.boards):
        for place, slot in enumerate(board.slots):
            yield slot, ("boards", number, "slots", place)


def _check_boards(profile: model.Profile, problems: Problems) -> None:
    if not profile.slots:
        problems.add("robot.slot", ("boards",), "no board has a slot")
    ids = [board.id for board in profile.boards]
    for number, each in enumerate(ids):
        if each in ids[:number]:
            problems.add("robot.board", ("boards", number, "id"), f"board {each} is listed twice")


def _check_slots(profile: model.Profile, problems: Problems) -> None:
    driven: set[tuple[str, str]] = set()
    names: set[str] = set()
    for slot, path in _slots(profile):
        if slot.name in names:
            problems.add("robot.slot", (*path, "name"), f"'{slot.name}' is listed twice")
        names.add(slot.name)
        drives = [(kind, getattr(slot, kind)) for kind in ("joint", "wheel", "roll")]
        targets = [(kind, name) for kind, name in drives if name is not None]
        if len(targets) > 1:
            message = "a slot drives one thing: joint, wheel or roll"
            problems.add("robot.slot", path, message)
        for kind, name in targets:
            if (kind == "roll") != (slot.unit == "angle"):
                message = f"a slot for a {kind} takes {_unit_for(kind)}, not {slot.unit}"
                problems.add("robot.slot", (*path, "unit"), message)
            if (kind, name) in driven:
                problems.add("robot.slot", (*path, kind), f"'{name}' is driven by two slots")
            driven.add((kind, name))
        if slot.limit is not None and slot.unit != "angle":
            problems.add("robot.slot", (*path, "limit"), "only an angle has a limit")


def _unit_for(kind: str) -> str:
    return "angle" if kind == "roll" else "duty"


def _check_channels(profile: model.Profile, problems: Problems) -> None:
    slots = {slot.name: slot for slot in profile.slots}
    for number, board in enumerate(profile.boards):
        for place, channel in enumerate(board.channels):
            path: Path = ("boards", number, "channels", place)
            if channel.slot is not None:
                _must_be(channel.slot, slots, "slot", (*path, "slot"), problems)
            slot = slots.get(channel.slot or "")
            if channel.senses in get_args(model.SlotSense) and channel.slot is None:
                message = f"`slot` must say whose {channel.senses} this is"
                problems.add("robot.channel", (*path, "senses"), message)
            elif channel.senses in get_args(model.SlotSense) and slot and not _drives(slot):
                message = f"'{slot.name}' drives nothing that could be measured"
                problems.add("robot.channel", (*path, "slot"), message)
            elif channel.senses == "torque" and slot and slot.joint is None:
                message = f"only a joint's torque is measured, and '{slot.name}' drives none"
                problems.add("robot.channel", (*path, "slot"), message)


def _drives(slot: model.Slot) -> bool:
    return any((slot.joint, slot.wheel, slot.roll))


def _check_safe_state(profile: model.Profile, problems: Problems) -> None:
    """Report wheels that turn in the safe state."""
    for slot in profile.slots:
        if slot.wheel is not None and slot.name not in profile.safe_state.zero:
            message = f"'{slot.name}' drives a wheel: it must be zero in the safe state"
            problems.add("robot.safe_state", ("safe_state", "zero"), message)


def _check_detector(profile: model.Profile, problems: Problems) -> None:
    names = [wheel.name for wheel in profile.body.wheels]
    for word, definition in profile.detector.words.items():
        for way, point in (("forward", definition.forward), ("backward", definition.backward)):
            path: Path = ("detector", "words", word, way, "wheel")
            if point is not None:
                _must_be(point.wheel, names, "wheel", path, problems)


def _check_defect(profile: model.Profile, defect: Defect, path: Path, problems: Problems) -> None:
    for key in DEFECT_NEEDS.get(defect.kind, ()):
        if not getattr(defect, key):
            problems.add("robot.defect", path, f"a {defect.kind} needs `{key}`", key=True)
    wheels = [wheel.name for wheel in profile.body.wheels]
    joints = [joint.name for joint in profile.body.joints]
    heard = [board for board in profile.boards if board.fitted and board.channels_fitted]
    signals = [channel.signal for board in heard for channel in board.channels if channel.signal]
    for number, name in enumerate(defect.wheels):
        _must_be(name, wheels, "wheel", (*path, "wheels", number), problems)
    if defect.joint is not None:
        _must_be(defect.joint, joints, "joint", (*path, "joint"), problems)
    for number, name in enumerate(defect.signals):
        _must_be(name, signals, "measured signal", (*path, "signals", number), problems)
    for name in defect.raw:
        _must_be(name, signals, "measured signal", (*path, "raw", name), problems, key=True)
    ids = [str(board.id) for board in heard]
    for number, board in enumerate(defect.boards):
        _must_be(str(board), ids, "board", (*path, "boards", number), problems)


def _must_be(
    name: str, valid: Iterable[str], kind: str, path: Path, problems: Problems, *, key: bool = False
) -> None:
    names = list(valid)
    if len(set(names)) < len(names):
        return  # a duplicate is reported already and may hide a missing name
    if name not in names:
        problems.add_unknown(f"robot.{kind.rpartition(' ')[2]}", path, kind, name, names, key=key)


def _refuse_twice(names: list[str], path: Path, problems: Problems) -> None:
    for number, name in enumerate(names):
        if name in names[:number]:
            problems.add("robot.name", (*path, number, "name"), f"'{name}' is listed twice")
