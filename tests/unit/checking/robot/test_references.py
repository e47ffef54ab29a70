"""Every reference of a sound robot, changed to each other name that is there, is reported."""

from __future__ import annotations

import copy
import random
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from representative import thorough_but

from pirate_sm.checking.findings import Severity
from pirate_sm.checking.robot.check_robot import check_robot
from pirate_sm.cli.commands.new import write_robot
from pirate_sm.cli.options.files import NewRobotOptions
from pirate_sm.core.loading import LoadedRobot, load_robot

from ..robots import NEWT, PIRATE, changed, told

Steps = tuple[str | int, ...]

REFERENCES = {
    r"body\.wheels\.\d+\.part": "part",
    r"body\.wheels\.\d+\.(angle|speed)": "signal",
    r"body\.links\.\d+\.module": "module",
    r"body\.links\.\d+\.roll": "signal",
    r"body\.joints\.\d+\.(name|torque)": "signal",
    r"body\.joints\.\d+\.wheel": "wheel",
    r"body\.joints\.\d+\.part": "part",
    r"body\.parts\.\w+\.apex": "joint",
    r"boards\.\d+\.module": "module",
    r"boards\.\d+\.slots\.\d+\.motor": "motor",
    r"boards\.\d+\.slots\.\d+\.joint": "joint",
    r"boards\.\d+\.slots\.\d+\.wheel": "wheel",
    r"boards\.\d+\.slots\.\d+\.roll": "signal",
    r"boards\.\d+\.channels\.\d+\.convert": "conversion",
    r"boards\.\d+\.channels\.\d+\.senses": "sense",
    r"boards\.\d+\.channels\.\d+\.slot": "slot",
    r"boards\.\d+\.channels\.\d+\.signal": "signal",
    r"derived\.\w+\.(odometry_of|speed_of|robot_speed_of)\.\d+": "wheel",
    r"derived\.\w+\.(slip_speed_of|slip_of|normal_force_of|friction_used_of|friction_of)": "wheel",
    r"derived\.\w+\.(rate_of|torque_of|bound_of|measured|speed)": "signal",
    r"derived\.\w+\.(roll_of|pitch_of|norm_of|least_of)\.\d+": "signal",
    r"derived\.\w+\.slot": "slot",
    r"derived\.\w+\.diameter_of": "part",
    r"commands\.\w+\.done\.(joints|loaded)\.\d+": "joint",
    r"commands\.\w+\.done\.signals\.\d+": "signal",
    r"commands\.\w+\.done\.slots\.\d+": "slot",
    r"commands\.\w+\.posture": "posture",
    r"postures\.\w+\.\d+\.done\.(joints|loaded)\.\d+": "joint",
    r"controls\.\w+\.extends": "control",
    r"aliases\.\w+": "command",
    r"seen\.parts\.\w+\.loaded\.\d+": "joint",
    r"safe_state\.zero\.\d+": "slot",
    r"faults\.\d+\.denies\.\d+": "part",
    r"detector\.words\.\w+\.\w+\.wheel": "wheel",
    r"simulation\.ruler\.signal": "signal",
    r"simulation\.defects\.\w+\.joint": "joint",
    r"simulation\.defects\.\w+\.wheels\.\d+": "wheel",
    r"simulation\.defects\.\w+\.signals\.\d+": "signal",
}
"""Where a profile names something, and what."""

NO_REFERENCES = re.compile(
    r"(robot|description|chart|format|serial\..*|travel\..*|plausibility\..*|not_commands\..*"
    r"|motors\.\w+\.kind|boards\.\d+\.(slots|channels)\.\d+\.(name|unit)|body\.wheels\.\d+\.name"
    r"|seen\.states\..*|faults\.\d+\.(code|of|of\.\d+)|rules\..*|controls\.\w+\.grip\..*"
    r"|detector\.words\.\w+\.joint|simulation\.defects\.\w+\.kind|link\.state_message)"
)
"""Names that are given here, and values with a few fixed choices."""

SENSES = ("angle", "torque", "current", "turned", "acc_x", "acc_y", "acc_z", "mag_x")

EXCEPTIONS = {
    r"boards\.\d+\.module": "only the file says where a board sits, unless it has an accelerometer",
    r"boards\.\d+\.channels\.\d+\.convert": "two scales of one unit differ in their numbers alone",
    r"boards\.\d+\.slots\.\d+\.motor": "motors of one kind differ in their numbers alone",
    r"derived\.\w+\.(norm_of|least_of)\.\d+": "the norm or least of any such signals has a meaning",
    r"derived\.\w+\.speed": "slip is reckoned against the ruler or what falls back from it",
    r"aliases\.\w+": "any command may have a second name",
    r"detector\.words\.\w+\.\w+\.wheel": "a word may begin to hold wherever any wheel is",
    r"simulation\.defects\..*": "anything may break",
    r"commands\.\w+\.done\.signals\.\d+": "any signals may have to be small before it is done",
    r"postures\.\w+\.\d+\.done\.loaded\.\d+": "another joint of the part may show that it holds",
    r"controls\.\w+\.extends": "a control may begin with what any other one does",
}
"""References of which another name may be right as well, and why."""


PARTS = 5
"""In one test they take so long that it is dumped where it is (`faulthandler_timeout`), and a
process that is dumped while it works may crash."""


def leaves(data: Any, at: Steps = ()) -> Iterator[tuple[Steps, str]]:
    """Every text in the data, with its path."""
    if isinstance(data, str):
        yield at, data
    if isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from leaves(value, (*at, key))


def dotted(at: Steps) -> str:
    return ".".join(map(str, at))


def kind_at(at: Steps) -> str:
    return next((kind for it, kind in REFERENCES.items() if re.fullmatch(it, dotted(at))), "")


def names_of(data: dict[str, Any]) -> dict[str, list[str]]:
    """The names in a profile, by what they name."""
    body, boards = data["body"], data["boards"]
    slots = [slot for board in boards for slot in board["slots"]]
    channels = [channel for board in boards for channel in board["channels"]]
    signals = [each["signal"] for each in channels if "signal" in each]
    return {
        "part": list(body["parts"]),
        "wheel": [each["name"] for each in body["wheels"]],
        "joint": [each["name"] for each in body["joints"]],
        "module": [each["module"] for each in body["links"]],
        "slot": [each["name"] for each in slots],
        "signal": [*signals, *data["derived"], *data.get("outside", {})],
        "motor": list(data["motors"]),
        "conversion": list(data["conversions"]),
        "command": list(data["commands"]),
        "posture": list(data.get("postures", {})),
        "control": list(data.get("controls", {})),
        "sense": list(SENSES),
    }


def is_unread(data: dict[str, Any], at: Steps) -> bool:
    """Return whether a reference is of a channel that is carried and not interpreted."""
    if at[0] != "boards" or at[2] != "channels":
        return False
    return "signal" not in data["boards"][at[1]]["channels"][at[3]]


def swaps(data: dict[str, Any]) -> list[tuple[Steps, str, str]]:
    """Every reference of a profile with each other name that is there."""
    names = names_of(data)
    return [
        (at, old, new)
        for at, old in leaves(data)
        for new in names.get(kind_at(at), ())
        if new != old and not is_unread(data, at)
    ]


CONDITIONS = re.compile(
    r"body\.parts\.\w+\.held|commands\.\w+\.asks_for|postures\.\w+\.\d+\.when|faults\.\d+\.when"
    r"|rules\.\d+\.(never|always|after|expect)|detector\.words\.\w+\.when"
)
"""Where a profile has a condition, with names in it."""

OF_SLOTS = re.compile(
    r"(actuation|controls\.\w+\.actuation)\.\w+\.\w+(\.\d+)?|postures\.\w+\.\d+\.set"
)
OF_STATES = re.compile(r"actuation\.\w+|seen\.states\.\w+")
"""Where the keys of a profile are names of slots, or of states."""

OTHER_EXCEPTIONS = {
    r"faults\.\d+\.when": "what is a fault is what the robot's people say",
    r"rules\.\d+\..*": "what must never happen is too",
    r"commands\.\w+\.asks_for": "it may ask for states that it does not lead to",
    r"actuation\.\w+": "what the name of a state means is known to people alone",
    r"(actuation|postures)\..*: bend_\d -> bend_\d": "of a V only the tip must press, in one stage",
    r"seen\..*: \w+Held -> \w+Held": "the parts show how many of them hold",
}
"""Names in conditions and keys of which another one may be right as well, and why."""


def mappings(data: Any, at: Steps = ()) -> Iterator[tuple[Steps, dict[str, Any]]]:
    """Every mapping in the data, with its path."""
    if isinstance(data, dict):
        yield at, data
    if isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from mappings(value, (*at, key))


def other_swaps(data: dict[str, Any], robot: LoadedRobot) -> Iterator[tuple[Steps, str, Any]]:
    """Every name in a condition and every key with each other name, and what it becomes."""
    names, table = names_of(data), robot.table
    pools = [*table.states, table.regions, names["signal"], names["command"]]
    pools.append(("clamps", "confirmed_clamps", "driven_wheels"))
    for at, text in leaves(data):
        for found in re.finditer(r"[A-Za-z_]\w*", text if CONDITIONS.fullmatch(dotted(at)) else ""):
            for pool in pools:
                for new in pool if found[0] in pool else ():
                    if new != found[0]:
                        swapped = text[: found.start()] + new + text[found.end() :]
                        yield at, f"{found[0]} -> {new}", swapped
    for at, keyed in mappings(data):
        slots, states = (each.fullmatch(dotted(at)) for each in (OF_SLOTS, OF_STATES))
        for old in keyed:
            for new in names["slot"] if slots else list(keyed) if states else ():
                if new != old and meaning(keyed.get(new)) != meaning(keyed[old]):
                    swapped = {{old: new, new: old}.get(key, key): keyed[key] for key in keyed}
                    yield at, f"{old} -> {new}", swapped


def meaning(value: Any) -> Any:
    """What a value says to a program: an explanation is for people."""
    return {k: v for k, v in value.items() if k != "why"} if isinstance(value, dict) else value


def put(data: dict[str, Any], at: Steps, new: Any) -> None:
    inner: Any = data
    for step in at[:-1]:
        inner = inner[step]
    inner[at[-1]] = new


def unnoticed(robot: Path, folder: Path, some: int, part: int = 0, parts: int = 1) -> list[str]:
    """Changed names of a robot, all or so many, of which nothing is said without a reason.

    Only one part of them, where they are tried in several.
    """
    target = folder / "robot"
    shutil.copytree(robot, target)
    file = target / "profile.yaml"
    data = yaml.safe_load(file.read_text(encoding="utf-8"))
    references = [(at, f"{old} -> {new}", new) for at, old, new in swaps(data)]
    others = list(other_swaps(data, load_robot(target)))
    found = []
    for every, exceptions in ((references, EXCEPTIONS), (others, OTHER_EXCEPTIONS)):
        chosen = random.Random(36).sample(every, min(some, len(every)))[part::parts]
        found += _unnoticed(target, data, chosen, exceptions)
    return found


def _unnoticed(
    target: Path,
    data: dict[str, Any],
    swapped: list[tuple[Steps, str, Any]],
    exceptions: dict[str, str],
) -> Iterator[str]:
    for at, what, new in swapped:
        wrong = copy.deepcopy(data)
        put(wrong, at, new)
        file = target / "profile.yaml"
        file.write_text(yaml.safe_dump(wrong, sort_keys=False), encoding="utf-8")
        findings = check_robot(target).findings
        text = f"{dotted(at)}: {what}"
        if not findings and not any(re.fullmatch(f"({it})(: .*)?", text) for it in exceptions):
            yield text
        assert all(each.place.line for each in findings), (at, new, findings)


@pytest.fixture
def template(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The robot that `pirate new robot` writes."""
    monkeypatch.chdir(tmp_path)
    write_robot(NewRobotOptions(name="fresh"))
    return tmp_path / "fresh"


WRONG = {
    "a second joint on a wheel": (
        "    - {name: hip,",
        "    - {name: nape, wheel: right_fore, part: nose, end_stop: 130 deg, torque: no_such}\n"
        "    - {name: hip,",
        "right_fore, part: nose, end_stop: 130 deg, torque: no_such}",
        "'nape' and 'neck' both sit at 'right_fore'", "name another wheel",
    ),
    "a joint without a slot": (
        "joint: hip, mirrors: true}", "roll: hip, mirrors: true}", "", "", "",
    ),
    "two wheels with one angle": (
        "angle: roll_b", "angle: roll_a", "roll_a, speed: spin_b",
        "'roll_a' is the angle of 'left_fore', not of 'right_fore'", "write `angle: roll_b`",
    ),
    "two wheels with one speed": (
        "speed: spin_b", "speed: spin_a", "spin_a}",
        "the rate of 'roll_a'", "write `speed: spin_b`",
    ),
    "the rate of another wheel": (
        "spin_b: {rate_of: roll_b}", "spin_b: {rate_of: roll_a}", "roll_a}",
        "the angle of 'right_fore' is 'roll_b'", "write `rate_of: roll_b`",
    ),
    "an apex in the other part": (
        "apex: neck", "apex: hip", "hip, held", "the V of 'nose'", "write `apex: neck`",
    ),
    "one wheel twice": (
        "odometry_of: [left_fore, right_fore", "odometry_of: [left_fore, left_fore", "left_fore, ",
        "'left_fore' is listed twice", "each name once",
    ),
    "an encoder on the slot of another wheel": (
        "senses: angle, slot: drive_b", "senses: angle, slot: drive_a", "drive_a}",
        "'drive_a' drives 'left_fore'", "write `slot: drive_b`",
    ),
    "the torque of another joint": (
        "torque: hip_torque", "torque: neck_torque", "neck_torque}",
        "'neck_torque' is the torque of 'neck', not of 'hip'", "write `torque: hip_torque`",
    ),
    "an angle for a torque": (
        "torque: hip_torque", "torque: hip", "hip}", "", "",
    ),
    "a wheel in the midst of another part": (
        "{name: right_hind, part: tail", "{name: right_hind, part: nose", "nose, direction",
        "'nose', which ends before it", "write `part: tail`",
    ),
    "a wheel with the motor of a joint": (
        "motor: track, wheel: left_fore", "motor: fold, wheel: left_fore", "fold, wheel",
        "with a motor of the kind sprung_worm", "write `motor: track`",
    ),
    "an angle in milliamperes": (
        "signal: neck, convert: fold_count", "signal: neck, convert: milliamps", "", "", "",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "at", "says", "fix"), WRONG.values(), ids=WRONG)
def test_the_finding_says_what_to_write(
    old: str, new: str, at: str, says: str, fix: str, tmp_path: Path
) -> None:
    found = check_robot(changed(NEWT, tmp_path, "profile.yaml", (old, new))).findings

    assert any(
        says in each.message and fix in each.fix and told([each])[0][1].startswith(at)
        for each in found
    ), found
    if says:
        assert [each.code for each in found].count("robot.reference") == 1, found


RUMP = "    - {module: rump, length: 80 mm, mass: 100 g}\n"
WHEEL = "{name: last, part: tail, direction: 1, mass: 50 g, angle: roll_e, speed: spin_e}"
SLOT = "{name: drive_e, unit: duty, motor: track, wheel: last, mirrors: true}"
CHANNEL = "{name: wheel_e, signal: roll_e, convert: wheel_count, senses: angle, slot: drive_e}"
LONGER = (
    (RUMP, RUMP + RUMP.replace("rump", "tip")),
    ("  links:\n", f"    - {WHEEL}\n  links:\n"),
    ("  parts:\n    nose", "    - {name: wag, wheel: right_hind, part: tail, end_stop: 130 deg}\n"
     "  parts:\n    nose"),
    ("wheel: right_hind, mirrors: true}\n", "wheel: right_hind, mirrors: true}\n"
     f"      - {SLOT}\n"),
    ("senses: angle, slot: drive_d}\n", f"senses: angle, slot: drive_d}}\n      - {CHANNEL}\n"
     "      - {name: wag, signal: wag, convert: fold_count}\n"),
    ("  spin_a:", "  spin_e: {rate_of: roll_e}\n  spin_a:"),
    ("drive_d: 0 %}", "drive_d: 0 %, drive_e: 0 %}"),
    ("drive_d: -80 %}", "drive_d: -80 %, drive_e: 80 %}"),
    ("drive_d: 80 %}", "drive_d: 80 %, drive_e: -80 %}"),
    ("drive_d]}", "drive_d, drive_e]}"),
)  # fmt: skip
"""A fifth wheel for the newt, and before it a joint that a board measures and nothing drives."""


def test_a_joint_that_is_measured_and_moves_freely_is_no_error(tmp_path: Path) -> None:
    found = check_robot(changed(NEWT, tmp_path, "profile.yaml", *LONGER)).findings

    (free,) = (each for each in found if each.message == "no slot drives 'wag'")
    assert free.severity is Severity.WARNING


def test_a_name_that_is_listed_twice_is_no_error(tmp_path: Path) -> None:
    swap = "odometry_of: [left_fore, right_fore", "odometry_of: [left_fore, left_fore"
    (found,) = check_robot(changed(NEWT, tmp_path, "profile.yaml", swap)).findings

    assert found.severity is Severity.WARNING


def test_only_lists_of_names_name_each_thing_once(tmp_path: Path) -> None:
    swap = (
        "robot: newt",
        "travel: {last: a, passages: [{joints: [mitre], calls: [b, b]}]}\nrobot: newt",
    )
    found = check_robot(changed(NEWT, tmp_path, "profile.yaml", swap)).findings

    assert [each.message for each in found if "twice" in each.message] == []


def test_a_missing_signal_of_a_wheel_is_not_said_to_be_that_of_another(tmp_path: Path) -> None:
    swap = "signal: roll_d, convert: wheel_count, ", "convert: wheel_count, "
    (found, *_) = check_robot(changed(NEWT, tmp_path, "profile.yaml", swap)).findings

    assert "roll_d" in found.message
    assert found.suggestion == ""


@pytest.mark.parametrize("robot", [NEWT, PIRATE], ids=lambda path: path.name)
def test_every_text_of_a_profile_is_known_to_be_a_reference_or_not(robot: Path) -> None:
    data = yaml.safe_load((robot / "profile.yaml").read_text(encoding="utf-8"))
    named = {name for names in names_of(data).values() for name in names}

    unknown = [
        dotted(at)
        for at, text in leaves(data)
        if text in named and not kind_at(at) and not NO_REFERENCES.fullmatch(dotted(at))
    ]

    assert unknown == []


@pytest.mark.parametrize("some", thorough_but([8], [8, 40]))
def test_a_wrong_reference_of_a_new_robot_is_reported(
    template: Path, some: int, tmp_path: Path
) -> None:
    assert unnoticed(template, tmp_path, some) == []


@pytest.mark.thorough
@pytest.mark.timeout(900)  # half a second for each change of the larger robot
@pytest.mark.parametrize("part", range(PARTS))
@pytest.mark.parametrize(("robot", "some"), [(NEWT, 10_000), (PIRATE, 150)], ids=("newt", "pirate"))
def test_a_wrong_reference_is_reported(robot: Path, some: int, part: int, tmp_path: Path) -> None:
    assert unnoticed(robot, tmp_path, some, part, PARTS) == []
