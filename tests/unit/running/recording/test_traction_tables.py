"""Slip, forces and friction of a run in its tables and its report, unknown where they are."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import pytest

from pirate_sm import Run, read, run
from pirate_sm.running.recording.csv_files import write_tables
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission

SLIPS = """\
format: 1
mission: slips
robot: pirate_ii
pipe: straight_113
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault: [{fault: [robot.stuck, wheel.dead, clamp.lost, grip.exhausted], then: continue}]
control: probing
start: slip
phases:
  slip:
    do: [DriveForward, {wait: [{after: 2.5 s}]}, {command: Brake, on_failure: continue}]
    go: done
ends: {done: {succeed: Slipped}}
"""
WHEELS = range(1, 7)
UNITS = {"slip_speed": "_m_per_s", "slip": "", "normal_force": "_N", "mu_used": "", "mu": ""}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot whose outer wheels slip, with a ruler and without."""
    folder = tmp_path_factory.mktemp("traction")
    mission = folder / "slips.yaml"
    mission.write_text(SLIPS, encoding="utf-8")
    for name, ruler in (("seen", True), ("alone", False)):
        file = folder / f"{name}.mcap"
        run(str(mission), ruler=ruler, record=file, check=False)
    return folder


@pytest.fixture(scope="module")
def seen(folder: Path) -> Run:
    return read(folder / "seen.mcap")


@pytest.fixture(scope="module")
def alone(folder: Path) -> Run:
    return read(folder / "alone.mcap")


def known(made: Run, name: str) -> list[float]:
    return [value for value in made.signals[name] if not math.isnan(value)]


def test_every_signal_of_a_wheel_is_a_column_with_its_unit(seen: Run) -> None:
    names = {f"{signal}_{n}{unit}" for signal, unit in UNITS.items() for n in WHEELS}

    assert names <= set(seen.signals)
    assert {"body_speed_m_per_s", "mu_estimate_front", "ruler_m_per_s"} <= set(seen.signals)


def test_what_slips_shows_its_friction(seen: Run) -> None:
    friction = known(seen, "mu_1")

    assert friction
    assert all(0.1 < value < 1.0 for value in friction)
    assert max(known(seen, "slip_speed_1_m_per_s")) > 0.010
    assert min(known(seen, "normal_force_1_N")) > 0


def test_without_a_ruler_slip_and_friction_are_unknown_and_forces_are_not(alone: Run) -> None:
    for n in WHEELS:
        assert known(alone, f"slip_speed_{n}_m_per_s") == []
        assert known(alone, f"mu_{n}") == []
        assert known(alone, f"normal_force_{n}_N")
    assert known(alone, "body_speed_m_per_s"), "wheels that agree show it"


@pytest.mark.thorough
def test_csv_files_hold_them_with_unknown_left_empty(folder: Path, seen: Run) -> None:
    for name in ("seen", "alone"):
        recording = read_recording(folder / f"{name}.mcap")
        with recorded_mission(recording.header) as loaded:
            write_tables(recording, loaded, folder / name)

    tables = {}
    for name in ("seen", "alone"):
        with (folder / name / "signals.csv").open(encoding="utf-8", newline="") as file:
            tables[name] = list(csv.DictReader(file))
    written = [row["mu_1"] for row in tables["seen"]]
    assert [float(cell) for cell in written if not _unknown(cell)] == pytest.approx(
        known(seen, "mu_1")
    )
    assert any(_unknown(cell) for cell in written)
    assert all(_unknown(row["mu_1"]) for row in tables["alone"])


def _unknown(cell: str) -> bool:
    return cell in ("", "nan", "NaN")


def test_the_report_plots_forces_always_and_friction_where_it_is_known(
    seen: Run, alone: Run
) -> None:
    with_ruler, without = (each.report().html for each in (seen, alone))

    assert "Normal forces" in with_ruler
    assert "Normal forces" in without
    assert '"Friction"' in with_ruler
    assert '"Friction"' not in without
