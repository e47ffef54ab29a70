from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pirate_sm

from .conftest import PATROL, ROOT


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
        (lambda: pirate_sm.load(PATROL, set=3), "set: expected values by the names of parameters"),
        (lambda: pirate_sm.check(PATROL, pipe=3), "expected a name or a path, got 3"),
        (lambda: pirate_sm.run(PATROL, "trace", defects=3), "defects: expected names of defects"),
        (lambda: pirate_sm.run(PATROL, defects=[{"a": 1}]), "defects: expected names of defects"),
        (lambda: pirate_sm.run(PATROL, start_jitter_m="1"), "start_jitter_m: expected a number"),
        (lambda: pirate_sm.run(PATROL, friction_jitter=7), "jitter of the friction: expected from"),
        (lambda: pirate_sm.run(PATROL, diameter_jitter_m=-1), "jitter of the diameter: expected"),
        (lambda: pirate_sm.run(PATROL, start_at_m="1 m"), "start_at_m: expected a number of m"),
        (lambda: pirate_sm.run(PATROL, None), "backend: expected the name of a backend, got None"),
        (lambda: pirate_sm.run(PATROL, "trace", record=3), "expected a name or a path, got 3"),
        (lambda: pirate_sm.read(None), "expected a name or a path, got None"),
        (lambda: pirate_sm.run(PATROL, states={"Grip": 3}), "states: expected names of states"),
        (lambda: pirate_sm.run(PATROL, detector=3), "detector: expected a text, got 3"),
        (lambda: pirate_sm.run(PATROL, states="Held"), "states: expected names of states"),
        (lambda: pirate_sm.run(PATROL, "physics", view="no"), "view: expected True or False"),
        (lambda: pirate_sm.run(PATROL, ruler=1), "ruler: expected True or False, got 1"),
        (lambda: pirate_sm.run(PATROL, "trace", view=True), "use backend='physics'"),
        (lambda: pirate_sm.run(PATROL, fidelity=2), "fidelity: expected usual or fast, got 2"),
        (lambda: pirate_sm.run(PATROL, "physics", fidelity="fast"), "use backend='sim'"),
        (lambda: pirate_sm.sweep(PATROL, backend="physics", view=True), "opens no viewer"),
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

    with pytest.raises(pirate_sm.UsageError, match="did you mean 'signals'"):
        run.table("signal")


CALLS = [pirate_sm.check, pirate_sm.load, pirate_sm.run, pirate_sm.session, pirate_sm.sweep]


@pytest.mark.parametrize("call", CALLS)
def test_a_name_that_no_mission_has_is_refused_with_the_names_that_there_are(
    call: Callable[[str], object],
) -> None:
    with pytest.raises(pirate_sm.UsageError) as caught:
        call("nope")
    for name in ("climb", "mitre_bend", "prepare_bend_backward"):
        assert name in str(caught.value)

    with pytest.raises(pirate_sm.UsageError, match="did you mean 'mitre_bend'"):
        call("mitre_bent")


@pytest.mark.parametrize("call", CALLS)
def test_a_file_that_is_not_there_is_the_same_error_everywhere(
    call: Callable[[Path], object], tmp_path: Path
) -> None:
    with pytest.raises(pirate_sm.UsageError, match=r"there is no .*x\.yaml"):
        call(tmp_path / "x.yaml")


def test_robot_and_pipe_may_be_paths() -> None:
    pipe = ROOT / "sequences" / "pipes" / "straight_113_upright.yaml"
    options: Any = {"robot": ROOT / "hardware_profiles" / "pirate_ii", "pipe": pipe}

    assert pirate_sm.load("climb", **options).pipe_name == pipe.stem
    assert pirate_sm.check("climb", **options) == pirate_sm.check("climb", pipe=pipe.stem)
    assert pirate_sm.run("climb", "trace", **options).header.pipe == pipe.stem


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"backend": "trace", "detector": "odometry"}, "use backend='sim'"),
        ({"backend": "trace", "defects": "rust"}, "use backend='sim'"),
        ({"backend": "serial"}, "port='/dev/ttyACM0'"),
        ({"start_at_m": 1.0}, "start_at_m goes with detector='odometry'"),
        ({"backend": "nope"}, "there is no backend 'nope'"),
        ({"detector": "nope"}, "there is no detector 'nope'"),
        ({"set": {"look": "3"}}, "parameter 'look'"),
    ],
)
def test_an_error_names_arguments_here_and_options_in_the_command_line(
    options: dict[str, Any], said: str
) -> None:
    with pytest.raises(pirate_sm.UsageError) as caught:
        pirate_sm.run(PATROL, **options)

    assert said in str(caught.value)
    assert "--" not in str(caught.value)
    assert "='" not in caught.value.for_terminal


def test_a_refused_mission_can_be_run_with_check_false(faulty: Path) -> None:
    with pytest.raises(pirate_sm.CheckError, match="check=False runs the mission") as caught:
        pirate_sm.run(faulty, "trace")

    assert "--no-check" in caught.value.for_terminal
    assert pirate_sm.run(faulty, "trace", check=False).outcome


def test_what_takes_longer_than_a_moment_is_logged(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pirate_sm.simulation.kinematic.world.is_compiled", lambda section: False)

    with caplog.at_level("INFO", logger="pirate_sm"):
        pirate_sm.session(PATROL)

    (record,) = caplog.records
    assert (record.name, record.levelname) == ("pirate_sm", "INFO")
    assert "Compiling the simulator" in record.getMessage()


def test_numbers_of_numpy_are_numbers() -> None:
    run = pirate_sm.run(PATROL, seed=np.int64(3), friction_jitter=np.float32(0.5))

    assert (run.header.options["seed"], run.header.options["friction_jitter"]) == (3, 0.5)
    assert pirate_sm.sweep(PATROL, np.arange(2), backend="trace", workers=1)["seed"] == [0, 1]
