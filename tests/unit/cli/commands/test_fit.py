from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pirate_sm
from pirate_sm.lab.fitting import advice


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """Slip and friction of two wheels by the law of fig. 4-3."""
    random = np.random.default_rng(4)
    slip = np.exp(random.uniform(np.log(1e-4), np.log(0.05), (2, 4000)))
    friction = np.interp(slip, [0, 0.001, 0.0015, 1], [0, 0.3, 0.2, 0.2])
    columns = [np.arange(4000) * 0.1, *slip, *friction]
    header = "time_s,slip_speed_1_m_per_s,slip_speed_2_m_per_s,used_1,used_2"
    file = tmp_path / "signals.csv"
    np.savetxt(file, np.column_stack(columns), delimiter=",", header=header, comments="")
    return file


@pytest.mark.thorough
def test_each_wheel_has_its_peak_its_plateau_and_both_curves(pirate: Any, table: Path) -> None:
    told = pirate("fit", table, "--friction", "used_{}", "--threshold", "1 mm/s")

    assert told.exit_code == 0
    assert told.stdout.startswith("wheel 1: 4000 points, slip up to 49.7 mm/s\n")
    assert "wheel 2:" in told.stdout
    for line in ("static, directly", "kinetic, directly", "peak of the Gaussian process"):
        assert told.stdout.count(f"  {line}") == 2
    assert "misfit" in told.stdout
    assert "for a pipe file (medians of the wheels): friction: {static: 0.3" in told.stdout


@pytest.mark.thorough
def test_it_is_written_into_a_pipe_file_a_page_and_a_table(
    pirate: Any, table: Path, tmp_path: Path
) -> None:
    pipe, page, csv = (tmp_path / name for name in ("pipe.yaml", "fit.html", "fit.csv"))
    pipe.write_text("format: 1\ndiameter: 120 mm\nsegments: [{straight: 1 m}]\n")

    told = pirate("fit", table, "--friction", "used_{}", "--write", pipe, "-o", page, "--csv", csv)

    assert told.exit_code == 0
    assert "friction: {static: 0." in pipe.read_text()
    assert page.read_text().count("<svg") == 2
    assert csv.read_text().splitlines()[0] == "wheel,what,value,low,high,reason"


@pytest.mark.thorough
def test_without_points_that_slip_the_plateau_is_refused_and_nothing_is_written(
    pirate: Any, table: Path, tmp_path: Path
) -> None:
    rows = table.read_text().splitlines()
    slow = [rows[0], *(row for row in rows[1:] if float(row.split(",")[1]) < 0.004)]
    table.write_text("\n".join(slow))
    pipe = tmp_path / "pipe.yaml"
    text = "format: 1\ndiameter: 120 mm\nsegments: [{straight: 1 m}]\n"
    pipe.write_text(text)

    told = pirate("fit", table, "--slip", "slip_speed_1", "--friction", "used_1", "--write", pipe)

    assert told.exit_code == 2
    assert "0 points above 5 mm/s of slip, a plateau needs 20" in told.output
    assert "kinetic friction is unknown" in told.output
    assert pipe.read_text() == text


def test_a_table_without_slip_names_the_options(pirate: Any, tmp_path: Path) -> None:
    file = tmp_path / "signals.csv"
    file.write_text("time_s,a\n0,1\n")

    told = pirate("fit", file)

    assert told.exit_code == 2
    assert "--slip and --friction" in told.output


def test_a_robot_is_not_estimated_from_a_table(pirate: Any, table: Path) -> None:
    told = pirate("fit", "--robot", table)

    assert told.exit_code == 2
    assert "a table does not say what the robot was commanded" in told.output


@pytest.mark.parametrize(
    "options", [("--predict",), ("--robot", "--predict", "--write", "twin.yaml")]
)
def test_a_prediction_goes_with_one_recording_of_a_robot(
    pirate: Any, table: Path, options: tuple[str, ...]
) -> None:
    told = pirate("fit", table, *options)

    assert told.exit_code == 2
    assert "--predict goes with --robot and one recording" in told.output


def test_advice_goes_with_a_recording_of_a_robot(pirate: Any, table: Path) -> None:
    assert "--advise goes with --robot" in pirate("fit", table, "--advise").output
    both = pirate("fit", table, "--robot", "--advise", "--predict")
    assert (both.exit_code, "cannot be given together" in both.output) == (2, True)
    told = pirate("fit", table, "--robot", "--advise")
    assert told.exit_code == 2
    assert "a table does not say what the robot was commanded" in told.output


@pytest.mark.parametrize("question", [(), ("--predict",), ("--advise",)])
def test_options_for_slip_and_friction_are_refused_for_a_robot(
    pirate: Any, table: Path, question: tuple[str, ...]
) -> None:
    told = pirate("fit", table, "--robot", *question, "--slip", "foo", "--radius", "24mm")

    assert told.exit_code == 2
    assert "--slip, --radius: only for slip and friction, without --robot" in told.output


def test_a_prediction_by_a_few_robots_is_refused(pirate: Any, table: Path) -> None:
    told = pirate("fit", table, "--robot", "--predict", "--robots", "18")

    assert (told.exit_code, "give at least 19" in told.output) == (2, True)


def test_advice_is_printed_and_its_table_has_every_number(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    numbers = {"wheel hold_torque": (0.9, 0.01), "bend stall_torque": (0.01, 0.002)}
    narrower = {name: advice.MeanGain(*gain) for name, gain in numbers.items()}
    found = advice.MissionAdvice("climb", advice.MeanGain(3.25, 0.5), narrower, 31.2, 3, 4)
    left_out = {"level": "there is no pipe"}
    advised = advice.AdvisedMissions([found], left_out, 4, 3, "it was stopped")
    monkeypatch.setattr(advice, "advise", lambda *_: advised)
    run, csv = tmp_path / "run.mcap", tmp_path / "advised.csv"
    pirate_sm.run("exp_2c_clamp", record=run)

    told = pirate("fit", "--robot", run, "--advise", "--csv", csv)

    assert told.stdout.splitlines() == [
        " 3.25 ± 0.50 bits  climb                         31 s, 3 of 4 succeed; "
        "narrows wheel hold_torque by 90%",
        "left out  level: there is no pipe",
        "rejected  3 of 7 robots: they end a recorded mission differently",
        "not all recordings could reject robots: it was stopped",
    ]
    assert csv.read_text().splitlines() == [
        "mission,number,gain,error,takes_s,succeeded,robots",
        'climb,"all, bits",3.25,0.5,31.2,3,4',
        "climb,wheel hold_torque,0.9,0.01,31.2,3,4",
        "climb,bend stall_torque,0.01,0.002,31.2,3,4",
    ]
    data = json.loads(pirate("fit", "--robot", run, "--advise", "--format", "json").stdout)
    assert data["advised"][0]["bits"] == {"mean": 3.25, "error": 0.5}
    assert data["advised"][0]["narrower"]["wheel hold_torque"] == {"mean": 0.9, "error": 0.01}
    assert data["left_out"] == left_out
    assert (data["robots"], data["rejected"], data["unchecked"]) == (4, 3, "it was stopped")


@pytest.mark.parametrize("options", [("--format", "json"), ("--workers", "1"), ("--robots", "64")])
def test_options_for_a_prediction_are_refused_without_one(
    pirate: Any, table: Path, options: tuple[str, ...]
) -> None:
    told = pirate("fit", table, *options)

    assert told.exit_code == 2
    assert "--format, --robots and --workers go with --predict and --advise" in told.output


def test_only_a_simulated_robot_takes_the_numbers_of_a_twin(
    pirate_run: Any, tmp_path: Path
) -> None:
    told = pirate_run("mitre_bend", "--backend", "trace", "--twin", tmp_path / "twin.yaml")

    assert told.exit_code == 2
    assert (
        "the backend trace has no simulated robot: use --backend sim, or leave out --twin"
        in told.output
    )
