from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest


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


@pytest.mark.parametrize("options", [("--format", "json"), ("--workers", "1")])
def test_what_only_a_prediction_has_is_refused_without_one(
    pirate: Any, table: Path, options: tuple[str, ...]
) -> None:
    told = pirate("fit", table, *options)

    assert told.exit_code == 2
    assert "--format and --workers go with --predict" in told.output


def test_only_a_simulated_robot_takes_the_numbers_of_a_twin(
    pirate_run: Any, tmp_path: Path
) -> None:
    told = pirate_run("mitre_bend", "--backend", "trace", "--twin", tmp_path / "twin.yaml")

    assert told.exit_code == 2
    assert (
        "the backend trace has no simulated robot: use --backend sim, or leave out --twin"
        in told.output
    )
