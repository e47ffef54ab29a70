"""Tables of a recording: SI units in the headers, numbers as they were."""

from __future__ import annotations

import csv

import pytest
from late import late
from recording_runs import record

import pirate_sm
from pirate_sm.cli.run_recording import RecordingOptions, recorded
from pirate_sm.running.recording.csv_files import _cell, write_tables
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare

pandas = late("pandas")


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    recording = record(folder / "run.mcap", Order("mitre_bend", seed=2))
    with recorded_mission(recording.header) as loaded:
        files = write_tables(recording, loaded, folder / "csv")
    return {file.stem: rows_of(file) for file in files}


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def test_each_topic_is_a_table(tables):
    assert {"signals", "setpoints", "states", "commands", "phases", "triggers", "end"} <= set(
        tables
    )


@pytest.mark.thorough
def test_places_are_those_that_the_simulator_knew(tmp_path):
    path = tmp_path / "run.mcap"
    prepared = prepare(Order("mitre_bend", seed=2))
    with recorded(prepared, RecordingOptions(record=str(path)), float("inf")) as kept:
        run = MissionRun(
            prepared.engine, prepared.backend, tap=kept.tap,
            companions=[*prepared.companions, *kept.companions, FirstChoice()],
        )  # fmt: skip
        kept.follow(run)
        run.execute()
    recording = read_recording(path)
    with recorded_mission(recording.header) as loaded:
        write_tables(recording, loaded, tmp_path / "csv")

    frame = pandas.read_csv(tmp_path / "csv" / "places.csv")

    assert list(frame.columns[:4]) == ["time_s", "known", "wheel_1_x_m", "wheel_1_y_m"]
    assert set(frame["known"]) == {1}
    assert frame["time_s"].is_monotonic_increasing
    # From the first leg, along x, into the second one, which leads off to side A.
    assert frame["wheel_1_y_m"].iloc[0] == pytest.approx(0, abs=0.01)
    assert frame["wheel_1_y_m"].iloc[-1] > 0.3


def test_headers_carry_si_units(tables):
    header = tables["signals"][0]

    assert header[0] == "time_s"
    assert {"gamma_1_rad", "bend_torque_1_Nm", "odometry_m", "speed_m_per_s"} <= set(header)
    assert {"bend_1_duty", "rotate_rad"} <= set(tables["setpoints"][0])


def test_every_line_is_as_long_as_its_header(tables):
    for rows in tables.values():
        assert {len(row) for row in rows} == {len(rows[0])}


def test_numbers_are_numbers_and_unknown_is_empty(tables):
    odometry = tables["signals"][0].index("odometry_m")
    column = [row[odometry] for row in tables["signals"][1:]]

    assert all(cell == "" or float(cell) >= -0.1 for cell in column)
    assert float(column[-1]) > 0.5


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@a", "\t=1", "\r=1"])
def test_text_does_not_begin_a_formula(text):
    assert _cell(text) == f"'{text}"
    assert _cell("a=1") == "a=1"
    assert _cell(-1.5) == -1.5


def test_the_states_are_those_of_the_mission(tables):
    region = tables["states"][0].index("BendingState")
    seen = [row[region] for row in tables["states"][1:]]

    assert "RearClampedFrontBending" in seen
    assert seen[-1] == "DoubleClamped"


def test_pandas_reads_them(tables, tmp_path):
    path = tmp_path / "signals.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(tables["signals"])

    frame = pandas.read_csv(path)

    assert frame["gamma_1_rad"].dtype == float
    assert frame["time_s"].is_monotonic_increasing


def test_a_folder_that_cannot_be_made_is_reported(tmp_path):
    recording = record(tmp_path / "run.mcap", Order("enter_2d", backend="trace"))
    (tmp_path / "file").write_text("", encoding="utf-8")

    with (
        recorded_mission(recording.header) as loaded,
        pytest.raises(OSError, match="directory"),
    ):
        write_tables(recording, loaded, tmp_path / "file" / "in")


def test_the_table_has_estimates_that_nothing_read_during_the_run(tables):
    heading, *rows = tables["signals"]
    forces = [float(row[heading.index("normal_force_1_N")] or "nan") for row in rows]

    assert sum(force > 5 for force in forces) > len(rows) / 4


@pytest.mark.thorough
def test_places_of_a_robot_in_space_have_three_coordinates_and_rolls(tmp_path):
    pirate_sm.run("turn_left", record=tmp_path / "run.mcap")
    recording = read_recording(tmp_path / "run.mcap")
    with recorded_mission(recording.header) as loaded:
        write_tables(recording, loaded, tmp_path / "csv")

    frame = pandas.read_csv(tmp_path / "csv" / "places.csv")

    rolls = ["roll_joint_rad", "roll_front_rad", "roll_rear_rad"]
    assert list(frame.columns[-4:]) == ["wheel_6_z_m", *rolls]
    # The rotation joint turns one part by a quarter against the other.
    assert frame["roll_joint_rad"].abs().max() == pytest.approx(1.57, abs=0.2)
