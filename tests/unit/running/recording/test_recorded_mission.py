"""A run that reads fitted numbers of its robot keeps them, and is made again from the recording."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from recording_runs import ROOT, record

from pirate_sm.core.effects import CommandStatus
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.robot.calibration_files import with_zeros
from pirate_sm.running.recording.format.header import RunHeader, header_of
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.recorded_mission import (
    recorded_fit,
    recorded_mission,
    recorded_robot,
    recorded_robot_files,
)
from pirate_sm.running.recording.replay import replay
from pirate_sm.running.wiring import Order

STALL_NM = 0.6
"""The profile assumes 1.01 Nm: 70 % of that are more than such a motor gives.

It turns fast, so that most of the time until a clamp counts is not that of winding its spring up.
"""


@pytest.fixture
def weak(tmp_path: Path) -> str:
    file = tmp_path / "weak.yaml"
    motors = f"{{bend: {{stall_torque: {STALL_NM} Nm, no_load_speed: 1 rad/s}}}}"
    file.write_text(f"format: 1\nrobot: pirate_ii\nmotors: {motors}\n", "utf-8")
    return str(file)


def clamped_after_s(recording: Recording, name: str = "ClampFront") -> float:
    """Return how long the first command of this name took to be confirmed."""
    at_s = {
        effect.status: step.at_s
        for step in reversed(list(recording.steps()))
        for effect in step.effects
        if isinstance(effect, CommandStatus) and effect.name == name
    }
    return at_s["done"] - at_s["accepted"]


def test_belief_in_a_clamp_asks_for_what_the_fitted_motor_bears(tmp_path: Path, weak: str) -> None:
    """Without the file a weak motor has to stand still for 1.5 s until its torque counts."""
    assumed = record(tmp_path / "assumed.mcap", Order("enter_2d", twin=weak, check=False))
    fitted = record(tmp_path / "fit.mcap", Order("enter_2d", twin=weak, fitted=weak, check=False))

    assert clamped_after_s(fitted) < clamped_after_s(assumed) - 0.8


def test_belief_from_a_fitted_file_is_replayed_without_the_file(tmp_path: Path, weak: str) -> None:
    recording = record(
        tmp_path / "run.mcap", Order("enter_2d", twin=weak, fitted=weak, check=False)
    )
    Path(weak).unlink()

    with recorded_mission(recording.header) as loaded:
        assert replay(recording, loaded).difference is None
    assert recorded_robot_files(recording.header).believed.motors["bend"].stall_torque == STALL_NM


def test_a_run_without_one_has_none(tmp_path: Path) -> None:
    recording = record(tmp_path / "run.mcap", Order("enter_2d", backend="trace"))

    assert recorded_fit(recording.header) is None
    believed = recorded_robot_files(recording.header)
    assert believed.believed is believed.profile


# --- the texts of a recording are loaded from a folder of their own ------------------------------

CALLING = """
format: 1
mission: calling
robot: ROBOT
start: own
phases:
  own: {do: [{call: parts/turn.yaml}, {call: beside}, {call: ../above.yaml}], go: shipped}
  shipped: {wait: [{after: 1 s, go: bend}, {after: 2 s, go: e}], within: {time: 8 s, go: e}}
  bend: {do: [{call: mitre_bend}], go: e}
ends: {e: {succeed: Done}}
"""
CALLED = """
format: 1
mission: NAME
robot: ROBOT
start: a
phases: {a: {do: [Brake], wait: [{after: 1 s, go: e}], within: {time: 9 s, go: e}}}
ends: {e: {succeed: Done}}
"""


def header_for(loaded: LoadedMission) -> RunHeader:
    """The header of a run of this mission."""
    began = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
    return header_of(
        loaded, began=began, backend="trace", nominal=True, detector="none", options={}
    )


@pytest.fixture
def calling(tmp_path: Path) -> Path:
    """A mission of a user that calls others beside, below and above it, and a shipped one."""
    robot = str(ROOT / "hardware_profiles" / "pirate_ii")
    folder = tmp_path / "missions"
    (folder / "parts").mkdir(parents=True)
    mission = folder / "calling.yaml"
    mission.write_text(CALLING.replace("ROBOT", robot), "utf-8")
    for name in ("parts/turn", "beside", "../above"):
        text = CALLED.replace("ROBOT", robot).replace("NAME", Path(name).name)
        (folder / f"{name}.yaml").write_text(text, "utf-8")
    return mission


@pytest.mark.parametrize("name", ["calling", "exp_1a_both"])
def test_the_program_of_a_recording_names_the_places_in_the_files_of_the_run(
    calling: Path, name: str
) -> None:
    mission = calling if name == "calling" else ROOT / "sequences" / f"{name}.yaml"
    loaded = load_mission(mission)

    with recorded_mission(header_for(loaded)) as again:
        assert again.program.instructions == loaded.program.instructions


def test_the_zeros_and_the_polarity_of_the_run_are_those_of_its_recording() -> None:
    loaded = load_mission(ROOT / "sequences" / "enter_2d.yaml")
    header, zeros = header_for(loaded), {"gamma_1": 0.25}
    calibrated = replace(header, zeros=zeros)

    assert recorded_robot(header).boards == loaded.loaded_robot.normal.boards
    mirrored = recorded_robot(replace(header, polarity="mirrored"))
    assert mirrored.actuation == loaded.loaded_robot.mirrored.actuation
    assert mirrored.actuation != loaded.loaded_robot.normal.actuation
    assert recorded_robot(calibrated).boards == with_zeros(loaded.robot, zeros).boards
    with recorded_mission(calibrated) as again:
        assert again.robot.boards == with_zeros(loaded.robot, zeros).boards
    with recorded_mission(header) as again:
        assert again.robot.boards == loaded.robot.boards


@pytest.mark.parametrize("chart", ["own.yaml", "charts/own.yaml", "../own.yaml"])
def test_a_chart_is_found_where_the_profile_says(tmp_path: Path, calling: Path, chart: str) -> None:
    shipped, robot = ROOT / "hardware_profiles" / "pirate_ii", tmp_path / "robots" / "mine"
    shutil.copytree(shipped, robot)
    (robot / "charts").mkdir()
    (robot / "chart.yaml").rename(robot / chart)
    profile = robot / "profile.yaml"
    profile.write_text(profile.read_text("utf-8").replace("chart: chart.yaml", f"chart: {chart}"))
    header = header_for(load_mission(calling, robot=str(robot)))

    with recorded_mission(header) as again:
        assert again.robot.regions == load_mission(calling, robot=str(robot)).robot.regions
    assert recorded_robot(header).regions == again.robot.regions


def load(header: RunHeader) -> None:
    with recorded_mission(header):
        pass


@pytest.mark.parametrize("loads", [load, recorded_robot])
def test_where_no_temporary_file_can_be_written_that_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, loads: Callable[[RunHeader], object]
) -> None:
    header = header_for(load_mission(ROOT / "sequences" / "enter_2d.yaml"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))

    with pytest.raises(RecordingError, match=r"temporary folder: .*; TMPDIR names another place"):
        loads(header)
