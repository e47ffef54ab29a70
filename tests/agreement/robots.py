"""Robots for missions that nobody wrote: two that stand in files, and any number made up.

A made-up robot has the body of the newt. Its chart, what its states hold and do, what its
commands ask for and its rules are drawn by lot.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from pirate_sm.core.documents import LoadError
from pirate_sm.core.loading import load_robot
from pirate_sm.core.robot import RobotSpec

ROOT = Path(__file__).resolve().parents[2]
PIRATE = ROOT / "hardware_profiles" / "pirate_ii"
NEWT = ROOT / "tests" / "robots" / "newt"

_FOLDER = TemporaryDirectory(prefix="agreement-")

_COMMON = (
    *("detector in ({words})", "segment == Joint", "not known(detector)", "not (segment == Joint)"),
    "known(segment) and not (segment in (Straight, Out))",
)
_OF_PIRATE = (
    *("odometry > 50 mm", "odometry <= 20 mm", "abs(speed) < 5 mm/s", "gamma_1 > 1 rad"),
    *("known(phi)", "not known(phi)", "roll > 0.1 rad", "odometry > 80 mm or speed > 10 mm/s"),
    *("max(gamma_1, gamma_2) > min(0.2 rad, gamma_3)", "odometry / 1 s > speed"),
)
_OF_NEWTS = (
    *("way > 50 mm", "way <= 20 mm", "abs(pace) < 5 mm/s", "neck > 1 rad", "known(hip)"),
    *("not known(hip)", "way / 1 s > pace", "way > 80 mm or pace > 10 mm/s"),
)
_ODD_COMMON = ("true", "false")
_ODD_OF_PIRATE = (
    *("BendingState == DoubleClamped", "not (LightingState == On)", "diameter_front > 1 m"),
    *("odometry > 50 mm and odometry < 20 mm", "abs(gamma_2) > 3 rad", "roll > 4 rad"),
)
_ODD_OF_NEWTS = (
    *("abs(neck) > 3 rad", "way > 50 mm and way < 20 mm", "width_nose > 1 m"),
    *("Grip == BothHeld", "not (Lamp == Lit)"),
)


@dataclass(frozen=True, repr=False)
class Words:
    """What missions for a robot can be made of.

    Attributes:
        folder: Where missions are written; stands for other missions to be called as well.
        conditions: Such as can become true and untrue.
        odd_conditions: Such as may always be one of both.
        faults: Codes that a mission may handle.
    """

    folder: Path
    path: Path
    robot: RobotSpec
    conditions: tuple[str, ...]
    odd_conditions: tuple[str, ...]
    faults: tuple[str, ...]
    called: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<{self.path}>"


@cache
def words_of(kind: str, seed: int = 0) -> Words:
    """The robot of this kind: ``pirate``, ``newt``, or ``made`` up from the seed."""
    folder = Path(_FOLDER.name) / f"{kind}-{seed}"
    folder.mkdir()
    path = {"pirate": PIRATE, "newt": NEWT}.get(kind) or _loadable(folder / "robot", Random(seed))
    robot = load_robot(path).oriented("normal")
    own = _OF_PIRATE if kind == "pirate" else _OF_NEWTS
    odd = _ODD_OF_PIRATE if kind == "pirate" else _ODD_OF_NEWTS
    spoken = ", ".join(robot.detector_words)
    conditions = tuple(each.format(words=spoken) for each in (*own, *_COMMON))
    codes = tuple(code for code, catchable in robot.fault_codes.items() if catchable)
    called = tuple(_called(folder, path, robot, Random(seed), name) for name in ("sub_a", "sub_b"))
    return Words(folder, path, robot, conditions, (*odd, *_ODD_COMMON), codes, called)


def _called(folder: Path, path: Path, robot: RobotSpec, lot: Random, name: str) -> str:
    """A mission to be called; one of the two says what it starts in."""
    table = robot.table
    start = lot.randrange(len(table.configurations))
    able = [c for c in range(len(table.commands)) if table.follow(start, c) != start] or [0]
    mission: dict[str, Any] = {
        "format": 1, "mission": name, "robot": str(path), "start": "inner",
        "phases": {"inner": {"do": [table.commands[lot.choice(able)]], "go": "through"}},
        "ends": {"through": {"succeed": "Through"}},
    }  # fmt: skip
    if name == "sub_a":
        mission["starts_in"] = dict(zip(robot.regions, table.configurations[start], strict=True))
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(mission), encoding="utf-8")
    return name


def _loadable(folder: Path, lot: Random) -> Path:
    """The first robot that is drawn and is one."""
    while True:
        try:
            load_robot(_made(folder, lot))
        except LoadError:
            shutil.rmtree(folder)
        else:
            return folder


def _made(folder: Path, lot: Random) -> Path:
    shutil.copytree(NEWT, folder)
    chart = yaml.safe_load((folder / "chart.yaml").read_text(encoding="utf-8"))
    profile = yaml.safe_load((folder / "profile.yaml").read_text(encoding="utf-8"))
    regions = chart["states"]["newt"]["states"]
    names = {region: [*each["states"]] for region, each in regions.items()}
    commands = [*profile["commands"]]
    for region in regions.values():
        for name, state in region["states"].items():
            state["transitions"] = _transitions(name, state, region, names, commands, lot)
    profile["body"]["parts"]["nose"]["held"] = _among("Grip", names, lot)
    profile["body"]["parts"]["tail"]["held"] = _among("Grip", names, lot)
    for command in profile["commands"].values():
        if lot.random() < 0.3:
            command["asks_for"] = _among(lot.choice([*names]), names, lot)
        command.pop("lets_go", None)
        if lot.random() < 0.3:
            command["lets_go"] = True
    _actuation(profile["actuation"], lot)
    profile["rules"] = [_rule(number, names, commands, lot) for number in range(lot.randrange(3))]
    for file, data in (("chart.yaml", chart), ("profile.yaml", profile)):
        (folder / file).write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return folder


def _transitions(
    name: str, state: Any, region: Any, names: Any, commands: list[str], lot: Random
) -> list[dict[str, str]]:
    """Those of the newt, some with another guard or left out, and some new ones."""
    found = []
    for each in state.get("transitions", []):
        if lot.random() < 0.1:
            continue
        if lot.random() < 0.25:
            guarded = {"event": each["event"], "target": each["target"]}
            found.append({**guarded, **_guard(name, names, lot)})
        else:
            found.append(each)
    for command in commands:
        if lot.random() < 0.08 and all(each["event"] != command for each in found):
            target = lot.choice([*region["states"]])
            if target != name:
                found.append({"event": command, "target": target, **_guard(name, names, lot)})
    return found


def _guard(name: str, names: Any, lot: Random) -> dict[str, str]:
    own = name.split(".", maxsplit=1)[0]
    other = lot.choice([state for region, each in names.items() if region != own for state in each])
    return lot.choice([{}, {"cond": f"In('{other}')"}, {"cond": f"not In('{other}')"}])


def _among(region: str, names: Any, lot: Random) -> str:
    states = [name.split(".")[1] for name in names[region]]
    some = lot.sample(states, lot.randint(1, len(states)))
    return f"{region} in ({', '.join(some)})"


def _actuation(actuation: Any, lot: Random) -> None:
    """Some states of the grip go in two stages, or seek an angle that others hold by force."""
    for state, slots in actuation["Grip"].items():
        if lot.random() < 0.3:
            sought = {slot: f"{lot.choice([-20, 15, 30])} deg" for slot in slots}
            actuation["Grip"][state] = lot.choice([sought, [sought, slots]])
    for state, slots in actuation["Crawl"].items():
        if lot.random() < 0.2:
            actuation["Crawl"][state] = dict.fromkeys(slots, lot.choice(["0 %", "50 %"]))


def _rule(number: int, names: Any, commands: list[str], lot: Random) -> dict[str, Any]:
    """A rule of any of the patterns."""
    said = [_among(region, names, lot) for region in names]
    said += ["clamps == 0", "driven_wheels > 0 and confirmed_clamps == 0", "clamps < 2"]
    said += [f"command == {lot.choice(commands)}"]
    rule: dict[str, Any] = {"rule": f"rule_{number}"}
    pattern = lot.choice(["never", "always", "after", "expect"])
    if pattern in {"never", "always"}:
        return rule | {pattern: lot.choice(said)}
    rule |= {"after": lot.choice(said)}
    if pattern == "after":
        return rule | {"never": lot.choice(said)}
    return rule | {"expect": lot.choice(said), "within_steps": lot.randint(1, 3)}


def configurations(words: Words) -> list[dict[str, str]]:
    """Every combination of states that the robot can be in, by region."""
    regions = words.robot.regions
    return [dict(zip(regions, each, strict=True)) for each in words.robot.table.configurations]


KINDS = [("pirate", 0), ("newt", 0), *product(["made"], range(1_000))]
