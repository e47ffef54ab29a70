"""The firmware's page, followed with a new robot: its tables, its firmware, its mission."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from pirate_sm.cli.entry import commands
from pirate_sm.core.loading import load_mission

from .avr_bay import Built
from .building import FIRMWARE, made
from .doctor import examined
from .rides import Ride

pytestmark = pytest.mark.timeout(900)

PAGE = (FIRMWARE.parent / "docs" / "firmware.md").read_text(encoding="utf-8")


def new_robot(folder: Path, change: Callable[[Any, Any], None] | None = None) -> Path:
    """A robot of the template, with what the page adds to it, and whatever else is changed.

    The page's messages have as many setpoints as that robot has slots.
    """
    commands(["new", "robot", str(folder)], standalone_mode=False)
    profile, chart = (folder / name for name in ("profile.yaml", "chart.yaml"))
    robot, machine = (yaml.safe_load(file.read_text(encoding="utf-8")) for file in (profile, chart))
    if change is not None:
        change(robot, machine)
    (section,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    profile.write_text(f"{yaml.safe_dump(robot, sort_keys=False)}\n{section}", encoding="utf-8")
    chart.write_text(yaml.safe_dump(machine, sort_keys=False), encoding="utf-8")
    slots = sum(len(board["slots"]) for board in robot["boards"])
    (folder / "messages").mkdir()
    for name, text in re.findall(r"`four/messages/(\S+)`.*?```text\n(.*?)```", PAGE, re.DOTALL):
        own = text.replace("int16[7]", f"int16[{slots}]")
        (folder / "messages" / name).write_text(own, encoding="utf-8")
    return folder


def shorten(robot: Any, machine: Any) -> None:
    """Make the template's robot one of four slots: three wheels, and a joint between two links."""
    body, boards, seen = robot["body"], robot["boards"], robot["seen"]
    body["wheels"].pop()
    body["wheels"][2]["part"] = "nose"
    body["links"].pop()
    body["joints"].pop()
    body["parts"] = {"nose": {"apex": "neck", "held": "Grip == NoseHeld"}}
    boards[0]["slots"].pop()
    boards[1]["slots"].pop()
    del boards[1]["channels"][3:]
    boards[2]["module"] = "trunk"
    boards[2]["slots"].pop()
    boards[2]["channels"].pop()
    for name in ("spin_4", "hip_rate", "width_tail"):
        del robot["derived"][name]
    robot["derived"]["way"]["odometry_of"].pop()
    robot["derived"]["pace"]["speed_of"].pop()
    folds = {"Loose": {"fold_neck": "0 deg"}, "NoseHeld": {"fold_neck": "-50 %"}}
    robot["actuation"] = {"Grip": folds, "Crawl": robot["actuation"]["Crawl"]}
    for duties in robot["actuation"]["Crawl"].values():
        del duties["drive_4"]
    for name in ("HoldTail", "FreeNose", "FreeTail", "SwitchLamp"):
        del robot["commands"][name]
    robot["commands"]["HoldNose"]["asks_for"] = "Grip == NoseHeld"
    robot["commands"]["Home"]["asks_for"] = "Grip == Loose and Crawl == Resting"
    robot["commands"]["Home"]["done"]["signals"] = ["neck"]
    del robot["motors"]["bulb"], seen["parts"]["tail"], seen["states"]["Lamp"]
    held = {"kind": "implied", "why": "the nose shows whether it holds"}
    seen["states"]["Grip"] = {"Loose": seen["states"]["Grip"]["Loose"], "NoseHeld": held}
    robot["safe_state"]["zero"].pop()
    robot["faults"] = robot["faults"][2:]
    robot["detector"]["words"]["near"]["backward"]["wheel"] = "wheel_3"
    del robot["travel"], robot["simulation"]["defects"]
    regions = machine["states"]["four"]["states"]
    del regions["Lamp"]
    loose, held = (regions["Grip"]["states"][f"Grip.{name}"] for name in ("Loose", "NoseHeld"))
    regions["Grip"]["states"] = {"Grip.Loose": loose, "Grip.NoseHeld": held}
    loose["transitions"].pop()
    held["transitions"].pop(0)


@pytest.mark.thorough
def test_the_page_leads_to_a_firmware_for_a_new_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = new_robot(Path("four"))

    commands(["firmware", str(folder), "-o", "robot.h"], standalone_mode=False)

    assert "static memory" in made("all", tmp_path / "build", tmp_path / "robot.h")


@pytest.mark.firmware
def test_a_robot_of_four_slots_is_go_and_does_its_mission_on_its_own_firmware(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, build: Callable[[Path], Built]
) -> None:
    """It drives up to a bend, with its one V pressed on both walls."""
    monkeypatch.chdir(tmp_path)
    folder = new_robot(Path("four"), shorten)
    mission = folder / "first_mission.yaml"
    lines = mission.read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if "HoldTail" not in line]
    mission.write_text("\n".join(kept), encoding="utf-8")
    loaded = load_mission(mission)
    built = build(folder)

    facts = examined(built, loaded)
    ended = Ride(built, loaded=loaded).run().ended

    assert facts.go, facts.findings
    assert (ended.outcome, ended.message) == ("succeeded", "At the bend")
