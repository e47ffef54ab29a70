from __future__ import annotations

from pathlib import Path

import pytest

import pirate_sm

from .conftest import PATROL


def test_a_parameter_is_given_as_a_mission_writes_it() -> None:
    assert pirate_sm.load(PATROL, set={"look": "3 s"}).parameters["look"] == "3 s"


def test_a_faulty_file_is_refused_with_every_place(tmp_path: Path) -> None:
    file = tmp_path / "patrol.yaml"
    file.write_text(PATROL.read_text("utf-8").replace("GoAhead", "GoAhed"), "utf-8")
    text = file.read_text("utf-8").replace("robot: ../newt", f"robot: {PATROL.parent}")
    file.write_text(text.replace("start: out", "start: owt"), "utf-8")

    with pytest.raises(pirate_sm.LoadError) as caught:
        pirate_sm.load(file)

    lines = [problem.place.line for problem in caught.value.problems]
    assert lines == sorted(lines)
    assert len(lines) > 1
    assert str(caught.value.problems[0].place).startswith(str(file))


def test_what_the_check_finds_has_code_and_place(tmp_path: Path) -> None:
    file = tmp_path / "patrol.yaml"
    text = PATROL.read_text("utf-8").replace("robot: ../newt", f"robot: {PATROL.parent}")
    file.write_text(text.replace("SwitchLamp", "SwitchLump", 1), "utf-8")

    (found,) = [each for each in pirate_sm.check(file) if "SwitchLump" in each.message]

    assert found.suggestion == "SwitchLamp"
    assert found.place.line > 1


def test_a_mission_without_faults_has_no_findings(patrol: pirate_sm.LoadedMission) -> None:
    assert pirate_sm.check("mitre_bend") == ()
    assert [each for each in pirate_sm.check(patrol) if each.severity.word == "error"] == []


def test_a_loaded_mission_takes_no_options_of_loading(patrol: pirate_sm.LoadedMission) -> None:
    with pytest.raises(pirate_sm.UsageError, match=r"give set to load\(\)"):
        pirate_sm.run(patrol, set={"look": "3 s"})
    with pytest.raises(pirate_sm.UsageError, match=r"give pipe to load\(\)"):
        pirate_sm.check(patrol, pipe="straight_113")
    with pytest.raises(pirate_sm.UsageError, match="by its name or file"):
        pirate_sm.run(patrol, start_phase="look")
