"""`pirate coverage`."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest
import yaml

from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.wiring import Order
from tests.unit.running.recording.recording_runs import record_cut_off

CUT_S = 19.8
"""The mission drives then."""

MISSION = """\
format: 1
mission: look
robot: pirate_ii
pipe: straight_113
on_failure: stop
start: drive
phases:
  drive:
    do: [ClampFront, {command: ClampRear, retry: 1}, DriveForward]
    wait: [{name: there, when: change(odometry) >= 50 mm, go: halt}]
    within: {time: 20 s, go: stop}
  halt:
    do:
      - {command: ToggleLighting, if: LightingState == Off}
      - Brake
    go: arrived
  stop: {do: [{command: Brake, unneeded: skip, on_failure: continue}], go: stopped}
ends:
  arrived: {succeed: Driven 5 cm}
  stopped: {fail: "Stopped: {cause}"}
"""


@pytest.fixture
def look(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "look.yaml"
    file.write_text(MISSION, "utf-8")
    return file


def measured(pirate: Any, *arguments: Any) -> dict[str, Any]:
    result = pirate("coverage", *arguments, "--format", "json")
    assert result.stderr == ""
    found: dict[str, Any] = json.loads(result.stdout)
    return found


def taken(found: dict[str, Any]) -> set[tuple[int, str]]:
    (file,) = found["files"]
    return {(each["line"], each["kind"]) for each in file["branches"] if each["taken"]}


def test_a_mission_that_nobody_has_run_is_only_possible(pirate: Any, look: Path) -> None:
    found = measured(pirate, look)

    assert (found["percent"], found["runs"]) == (0, {"model": 1})
    (file,) = found["files"]
    possible = {(each["line"], each["kind"]) for each in file["branches"] if each["seen"]}
    assert {(9, "retry"), (9, "on_failure"), (10, "trigger"), (11, "within")} <= possible


def test_a_rehearsal_takes_what_goes_well(pirate: Any, look: Path) -> None:
    found = measured(pirate, look, "--rehearse", 1)

    assert taken(found) == {(10, "trigger"), (14, "if")}
    (file,) = found["files"]
    (fired,) = (each for each in file["branches"] if each["kind"] == "trigger")
    assert fired["seen"]["simulated"]["times"] == 1
    assert fired["seen"]["simulated"]["first"].startswith("run look.yaml")


def test_a_recording_counts_with_what_it_shows(pirate: Any, look: Path) -> None:
    pirate("run", look, "--record", "sim.mcap", "--quiet", "--speed", "max")
    pirate(
        "run", look, "--backend", "trace", "--fire", "within", "--record", "trace.mcap", "--quiet"
    )

    assert taken(measured(pirate, look, "sim.mcap")) == {(10, "trigger"), (14, "if")}
    assert (11, "within") not in taken(measured(pirate, look, "."))
    assert (11, "within") in taken(measured(pirate, look, ".", "--evidence", "trace"))
    assert taken(measured(pirate, look, ".", "--evidence", "robot")) == set()


def test_recordings_alone_are_held_against_their_own_missions(pirate: Any, look: Path) -> None:
    pirate("run", look, "--record", "sim.mcap", "--quiet", "--speed", "max")
    look.unlink()

    found = measured(pirate, "sim.mcap")
    assert found["files"][0]["file"].endswith("look.yaml")
    assert taken(found) == {(10, "trigger"), (14, "if")}


def test_a_run_of_another_text_does_not_count_and_is_named(pirate: Any, look: Path) -> None:
    pirate("run", look, "--record", "sim.mcap", "--quiet", "--speed", "max")
    look.write_text(MISSION.replace("50 mm", "60 mm"), "utf-8")

    result = pirate("coverage", look, "sim.mcap", "--format", "json")
    found = json.loads(result.stdout)
    assert found["percent"] == 0
    assert "sim.mcap: of no mission here, or of another text of it" in result.stderr
    assert len(found["not_counted"]) == 1


def test_a_file_that_is_no_recording_is_named_and_the_others_count(pirate: Any, look: Path) -> None:
    pirate("run", look, "--record", "sim.mcap", "--quiet", "--speed", "max")
    Path("bad.mcap").write_bytes(b"nothing")

    result = pirate("coverage", look, ".")
    assert "bad.mcap" in result.stderr
    assert "1 simulated" in result.stdout


@pytest.mark.thorough
def test_a_run_that_was_resumed_counts_with_and_without_its_mission(
    pirate: Any, look: Path
) -> None:
    record_cut_off(Path("cut.mcap"), Order("look.yaml"), CUT_S)
    resumed = pirate(
        "run", "--resume", "cut.mcap", "--accept", "--speed", "max", "--record", "on.mcap"
    )
    assert resumed.exit_code == 0, resumed.output

    alone = measured(pirate, "on.mcap")
    assert taken(alone) == taken(measured(pirate, look, "on.mcap")) == {(10, "trigger"), (14, "if")}
    (before,) = read_recording(Path("on.mcap")).header.resumed
    assert '"restoring":[]' not in before.resumption


def test_too_few_branches_are_an_exit_code(pirate: Any, look: Path) -> None:
    assert pirate("coverage", look, "--at-least", 1).exit_code == 1
    assert pirate("coverage", look, "--rehearse", 1, "--at-least", 10).exit_code == 0
    assert pirate("coverage", look, "--at-least", 101).exit_code == 2
    assert pirate("coverage", "nowhere.yaml").exit_code == 2
    assert pirate("coverage", "nowhere.mcap").exit_code == 2


def test_lines_are_shown_with_what_was_not_taken(pirate: Any, look: Path) -> None:
    lines = pirate("coverage", look, "--rehearse", 1).stdout.splitlines()

    assert lines[0] == "look.yaml: 2 of 11 branches, 18 %"
    at = next(n for n, line in enumerate(lines) if line.startswith("   11 ! "))
    assert lines[at + 1].strip() == "! within: 20 s have passed → stop (possible)"
    assert any(line.startswith("   10 > ") for line in lines)


def test_a_called_mission_is_covered_by_its_callers(pirate: Any, look: Path) -> None:
    caller = look.with_name("caller.yaml")
    caller.write_text(
        "format: 1\nmission: caller\nrobot: pirate_ii\npipe: straight_113\nstart: go\n"
        "phases: {go: {do: [{call: ./look.yaml}], go: done}}\nends: {done: {succeed: ok}}\n",
        "utf-8",
    )

    found = measured(pirate, caller, "--rehearse", 1)
    names = {each["file"]: each["percent"] for each in found["files"]}
    assert names["look.yaml"] > 0


def test_lcov_and_the_page_are_written_over_their_own_only(pirate: Any, look: Path) -> None:
    for _ in range(2):
        result = pirate("coverage", look, "--rehearse", 1, "--html", "c.html", "--lcov", "c.info")
        assert result.exit_code == 0
    lcov = Path("c.info").read_text("utf-8").splitlines()
    assert lcov[:2] == ["TN:pirate-sm", "SF:look.yaml"]
    assert {"BRF:11", "BRH:2", "end_of_record"} <= set(lcov)
    page = Path("c.html").read_text("utf-8")
    assert "change(odometry) &gt;= 50 mm" in page
    assert "<script" not in page
    Path("c.info").write_text("mine", "utf-8")
    assert pirate("coverage", look, "--lcov", "c.info").exit_code == 2


@pytest.mark.parametrize("name", ["look_branches.yaml", "look_branches_4.script.yaml"])
def test_scenes_and_scripts_that_may_be_edited_are_not_replaced(
    pirate: Any, look: Path, name: str
) -> None:
    mine = Path("more", name)
    mine.parent.mkdir()
    mine.write_text("mine", "utf-8")

    result = pirate("coverage", look, "--write-missing", "more", "--tries", 0)

    assert result.exit_code == 2
    assert name in result.stderr
    assert [*mine.parent.iterdir()] == [mine]
    assert mine.read_text("utf-8") == "mine"


@pytest.mark.thorough
def test_missing_branches_are_rehearsed_and_written_as_a_scene(pirate: Any, look: Path) -> None:
    result = pirate(
        "coverage", look, "--write-missing", "more", "--tries", 2, "--format", "json",
        "--evidence", "trace",
    )  # fmt: skip
    found = json.loads(result.stdout)

    assert {each["kind"] for each in found["files"][0]["branches"] if not each["taken"]} == {"else"}
    assert "no run was found that takes else: not LightingState == Off" in result.stderr
    scene = Path("more/look_branches.yaml")
    assert pirate("check", scene).exit_code == 0
    steps = yaml.safe_load(scene.read_text("utf-8"))["steps"]
    for number, step in enumerate(steps):
        words = shlex.split(step["command"].replace("{here}", "more").replace("{out}", "."))
        assert pirate(*words, "--quiet", "--speed", "max").exit_code == step["expect"]["exit"], (
            number
        )
    again = measured(pirate, look, ".", "--evidence", "trace")
    assert taken(again) == taken(found)
    assert pirate("coverage", look, "--write-missing", "more").exit_code == 2, "it may be edited"


@pytest.mark.thorough
def test_a_campaign_is_rehearsed_cell_by_cell(pirate: Any, look: Path) -> None:
    campaign = look.with_name("trial.yaml")
    campaign.write_text(
        "format: 1\ncampaign: trial\nmissions: [look.yaml]\nseeds: 3\n"
        "defects: [[], [wheels_3_4_dead]]\n",
        "utf-8",
    )

    found = measured(pirate, campaign, "--rehearse", 2)
    assert found["runs"]["simulated"] == 4
