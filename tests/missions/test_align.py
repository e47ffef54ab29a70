"""Parts that are turned in a round pipe in space: by a quarter, and level by the accelerometer."""

from __future__ import annotations

import re
from math import nan
from pathlib import Path

import pytest
from representative import thorough_but
from typer.testing import CliRunner

from benchmarks.align import COMMANDS, HOLDERS, WITHIN_DEG, Trial, drive_off, show, try_out
from benchmarks.campaign import run
from pirate_sm import api
from pirate_sm.cli.entry import commands
from pirate_sm.running.wiring import Order

ROUND = """\
format: 1
pipe: tube
diameter: 120 mm
section: round
roll: {roll}
segments: [{{straight: 1.135 m}}]
start: {{at: 500 mm}}
"""


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("holder", HOLDERS)
@pytest.mark.parametrize("roll_deg", thorough_but([60.0, 270.0], [0.0, 60.0, 150.0, 270.0]))
def test_a_part_comes_level_by_the_truth_of_the_simulator(command, holder, roll_deg):
    trial = try_out((command, holder, roll_deg, 0))
    assert trial.why == ""
    assert abs(trial.off_deg) <= WITHIN_DEG


@pytest.mark.slow
@pytest.mark.parametrize("diameter_mm", [105.0, 115.0, 120.0])
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("holder", HOLDERS)
def test_it_does_so_from_every_roll_in_every_pipe(command, holder, diameter_mm):
    trials = [
        try_out((command, holder, roll_deg, 1), diameter_mm=diameter_mm)
        for roll_deg in range(0, 360, 30)
    ]
    assert [each for each in trials if not each.passes] == []
    assert [each for each in trials if each.why] == []


@pytest.mark.parametrize("holder", HOLDERS)
def test_in_a_steep_pipe_it_says_that_it_is_impossible(holder):
    trial = try_out(("AlignHorizontal", holder, 30.0, 0), pitch_deg=70.0)
    assert re.search(r"impossible: the pipe is (69|70|71) deg steep here", trial.why)
    assert trial.passes


@pytest.mark.parametrize("seed", thorough_but([0], range(3)))
@pytest.mark.parametrize(
    ("roll", "message"),
    [
        ("-90 deg", "Both parts in the horizontal plane and driving"),
        ("0 deg", "Holding, both parts clamped, in a plane that is not horizontal"),
    ],
    ids=["upright", "lying"],
)
def test_both_parts_turn_by_a_quarter_in_a_round_pipe_in_the_simulator(
    tmp_path: Path, roll: str, message: str, seed: int
) -> None:
    """The backend physics says the same: a robot that is put down lying ends upright."""
    pipe = tmp_path / "tube.yaml"
    pipe.write_text(ROUND.format(roll=roll))

    assert run(Order("enter_3d", pipe=str(pipe), seed=seed)).message == message


@pytest.mark.parametrize("roll_deg", thorough_but([-105.0], [-105.0, 40.0, 130.0]))
def test_a_robot_that_is_put_in_anyhow_drives_in_the_horizontal_plane(roll_deg):
    trial = drive_off(roll_deg)
    assert trial.why == ""
    assert abs(trial.off_deg) <= 10.0


def test_an_inertial_unit_that_is_stuck_levels_nothing_and_says_so() -> None:
    outcome = run(Order("level", defects=("imu_stale",)))

    assert outcome.outcome == "failed"
    assert outcome.message.startswith("Holding, both parts clamped, as they lie: AlignHorizontal")
    assert "deg off after a correction, more than 3 deg" in outcome.message
    assert outcome.states[-1][2] == "DoubleClamped"


@pytest.mark.slow
def test_it_does_so_from_every_roll():
    assert [each for each in map(drive_off, range(0, 360, 30)) if each.why] == []


def test_a_recording_of_a_robot_that_extends_another_is_replayed_alike(tmp_path: Path) -> None:
    file = tmp_path / "level.mcap"
    assert api.run("level", seed=2, record=file).outcome == "succeeded"

    result = CliRunner().invoke(commands, ["replay", str(file)])

    assert result.exit_code == 0, result.output


def test_a_command_that_never_came_to_a_level_is_told_in_words(capsys) -> None:
    failed = Trial("AlignHorizontal", "rear", 0.0, 0, nan, "impossible: too steep", 1.0)
    show([failed])
    printed = capsys.readouterr().out
    assert "none came to a level" in printed
    assert "nan" not in printed
