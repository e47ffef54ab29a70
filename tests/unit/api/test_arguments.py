from __future__ import annotations

from collections.abc import Callable
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


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: pirate_sm.load(None), "expected a name or a path, got None"),
        (lambda: pirate_sm.check(3), "expected a name or a path, got 3"),
        (lambda: pirate_sm.run(PATROL, "trace", seed=-1), "seed: expected a whole number from 0"),
        (lambda: pirate_sm.run(PATROL, "trace", pip="x"), "no option 'pip': did you mean 'pipe'"),
        (lambda: pirate_sm.sweep(PATROL, "12", backend="trace"), "seeds: expected whole numbers"),
        (lambda: pirate_sm.sweep(PATROL, [1.5], backend="trace"), "seeds: expected a whole number"),
        (lambda: pirate_sm.sweep(PATROL, backend="trace", workers="2"), "workers: expected"),
        (lambda: pirate_sm.sweep(PATROL, backend="trace", workers=0), "workers: expected"),
        (
            lambda: pirate_sm.sweep(PATROL, [1], backend="trace", record="a.mcap"),
            "no option 'record'",
        ),
    ],
)
def test_an_argument_that_does_not_fit_is_an_error_of_the_package(
    call: Callable[[], object], words: str
) -> None:
    with pytest.raises(pirate_sm.UsageError) as caught:
        call()

    assert words in str(caught.value)


def test_a_table_that_no_run_has_is_refused() -> None:
    run = pirate_sm.run(PATROL, "trace")

    assert run.table("faults") == {}
    with pytest.raises(pirate_sm.UsageError, match="did you mean 'signals'"):
        run.table("signal")
