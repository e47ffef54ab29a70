from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.experiments import needed_extras
from pirate_sm.lab.experiments.experiment_files import load_experiments
from pirate_sm.lab.experiments.setups import ExperimentResult, OwnLoops, TractionSetup
from pirate_sm.lab.experiments.traction_experiment import repeat_with_loops

ROBOT = Path(__file__).parents[4] / "hardware_profiles" / "pirate_ii"
MISSIONS = {"3a": "exp_3a", "3d": "exp_3d"}


@pytest.fixture(scope="module")
def result() -> ExperimentResult:
    """The variant with everything, on the quicker of the two simulated physics."""
    loops = OwnLoops(backend="sim", missions=MISSIONS, since="DriveBackward")
    return repeat_with_loops(loops, ("3b", "3d"))


@pytest.mark.thorough
def test_a_drive_there_and_back_ends_where_it_began_and_wheels_tell_its_way(
    result: ExperimentResult,
) -> None:
    assert 0.85 < result.values["3d.sim.way"] < 0.95
    assert abs(result.values["3d.sim.place"]) < 0.03
    assert result.values["3d.sim.error"] < 0.005


@pytest.mark.thorough
def test_what_each_run_came_to_is_told_and_drawn(result: ExperimentResult) -> None:
    assert len(result.notes) == 1, "no mission stands for 3b"
    assert result.notes[0].startswith("3d on sim: succeeded after ")
    (figure,) = result.figures
    assert [series.name for series in figure.series] == ["3d"]


def test_without_its_backend_nothing_is_run_and_that_is_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(needed_extras, "find_spec", lambda module: None)
    loops = OwnLoops(backend="physics", missions=MISSIONS, since="DriveBackward")

    made = repeat_with_loops(loops, ("3a", "3d"))

    assert made.values == {}
    (note,) = made.notes
    assert "not run, mujoco is not installed: pip install 'pirate-sm[physics]'" in note


def test_a_mission_that_never_gives_the_command_is_refused() -> None:
    loops = OwnLoops(backend="trace", missions=MISSIONS, since="AlignLeft")
    with pytest.raises(UsageError, match=r"exp_3a: experiments need .* the command AlignLeft"):
        repeat_with_loops(loops, ("3a",))


@pytest.mark.slow
def test_the_shipped_variants_run_on_the_physics_and_stick() -> None:
    (setup,) = (each for each in load_experiments(ROBOT) if isinstance(each, TractionSetup))
    assert setup.loops is not None
    made = repeat_with_loops(setup.loops, ("3a", "3b"))
    for part in ("3a", "3b"):
        assert 0.85 < made.values[f"{part}.physics.way"] < 0.95
        assert made.values[f"{part}.physics.error"] < 0.005
