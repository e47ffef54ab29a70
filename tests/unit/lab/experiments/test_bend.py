from math import radians
from pathlib import Path

import pytest

from pirate_sm.lab.experiments import needed_extras
from pirate_sm.lab.experiments.bend import repeat_bend
from pirate_sm.lab.experiments.experiment_files import load_experiments
from pirate_sm.lab.experiments.setups import BendSetup

ROBOT = Path(__file__).parents[4] / "hardware_profiles" / "pirate_ii"


@pytest.fixture(scope="module")
def setup() -> BendSetup:
    (found,) = (each for each in load_experiments(ROBOT) if isinstance(each, BendSetup))
    return found.model_copy(update={"seen": {}})


@pytest.mark.thorough
def test_the_bend_is_passed_by_commands_and_by_sequences(setup: BendSetup) -> None:
    values = repeat_bend(setup, ("2a", "2b")).values

    assert (values["2a.passed"], values["2b.passed"]) == (1, 1)
    assert values["2b.over_2a"] == pytest.approx(1, abs=0.2)


@pytest.mark.thorough
def test_a_part_is_repeated_by_what_a_camera_sees(
    setup: BendSetup, monkeypatch: pytest.MonkeyPatch
) -> None:
    camera = str(ROBOT.parents[1] / "tests" / "cameras" / "small.yaml")
    seen = setup.model_copy(update={"seen": {"2b": camera}})

    assert repeat_bend(seen, ("2b",)).values["2b.seen.passed"] == 1

    monkeypatch.setattr(needed_extras, "find_spec", lambda module: None)
    without = repeat_bend(seen, ("2b",))
    assert "2b.seen.passed" not in without.values
    assert "pip install 'pirate-sm[vision]'" in without.notes[-1]


@pytest.mark.thorough
def test_the_tilt_is_raised_until_a_mission_fails_or_the_last_one_is_tried(
    setup: BendSetup,
) -> None:
    clamped = setup.tilts.missions["clamped"]
    tilts = setup.tilts.model_copy(update={"missions": {"clamped": clamped}, "step": radians(31)})
    held = repeat_bend(setup.model_copy(update={"tilts": tilts}), ("2c",))

    strict = tilts.model_copy(update={"slides": -1.0})
    never = repeat_bend(setup.model_copy(update={"tilts": strict}), ("2c",))

    assert held.values["2c.snapshots"] == 9
    assert held.values["2c.clamped_tilt"] == pytest.approx(radians(90))
    assert "at 28 deg: it slides by" in never.notes[-1]
