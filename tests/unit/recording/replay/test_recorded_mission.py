"""A run that reads fitted numbers of its robot keeps them, and is made again from the recording."""

from __future__ import annotations

from pathlib import Path

import pytest
from recording_runs import record

from pirate_sm.model.effects import CommandStatus
from pirate_sm.recording.read.reader import Recording
from pirate_sm.recording.replay.recorded_mission import (
    recorded_fit,
    recorded_mission,
    recorded_robot_files,
)
from pirate_sm.recording.replay.replay import replay
from pirate_sm.wiring import Order

STALL_NM = 0.6
"""The profile assumes 1.01 Nm: 70 % of that are more than such a motor gives."""


@pytest.fixture
def weak(tmp_path: Path) -> str:
    file = tmp_path / "weak.yaml"
    motors = f"{{bend: {{stall_torque: {STALL_NM} Nm}}}}"
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
