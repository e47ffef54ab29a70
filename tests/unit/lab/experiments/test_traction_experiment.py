from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_robot
from pirate_sm.lab.experiments.experiment_files import load_experiments
from pirate_sm.lab.experiments.setups import ExperimentResult, TractionSetup
from pirate_sm.lab.experiments.traction_experiment import repeat_traction

ROBOT = Path(__file__).parents[4] / "hardware_profiles" / "pirate_ii"
PROFILE = load_robot(ROBOT).profile
(SHIPPED,) = (each for each in load_experiments(ROBOT) if isinstance(each, TractionSetup))
SETUP = SHIPPED.model_copy(update={"loops": None})


@pytest.fixture(scope="module")
def result() -> ExperimentResult:
    shares: list[float] = []
    made = repeat_traction(PROFILE, SETUP, ("3c", "3d"), seeds=3, watch=shares.append)
    assert shares == sorted(shares)
    return made


@pytest.mark.thorough
@pytest.mark.thorough
def test_values_are_there_for_every_level_of_noise_and_where_friction_sticks(
    result: ExperimentResult,
) -> None:
    for level in ("clean", "thesis", "sticking"):
        assert {f"3c.{level}.{name}" for name in ("error", "way", "place")} <= set(result.values)


@pytest.mark.thorough
def test_a_compensated_variant_is_compared_with_its_partner(result: ExperimentResult) -> None:
    assert result.values["3d.thesis.apart"] < 1e-3
    assert result.values["3d.clean.kept"] > 0.1
    assert "3c.thesis.apart" not in result.values


@pytest.mark.thorough
def test_the_curves_of_the_run_apart_have_the_friction_that_was_put_in(
    result: ExperimentResult,
) -> None:
    for wheel, static, kinetic in (("wheel_1", 0.3, 0.2), ("wheel_5", 0.7, 0.5)):
        found = {name: result.values[f"3d.{wheel}.{name}"] for name in ("static", "kinetic")}
        assert found == pytest.approx({"static": static, "kinetic": kinetic}, rel=0.01)
        assert result.values[f"3d.{wheel}.process_peak"] == pytest.approx(static, rel=0.05)
        assert result.values[f"3d.{wheel}.magic_plateau"] == pytest.approx(kinetic, rel=0.05)


@pytest.mark.thorough
def test_the_figures_of_the_thesis_are_drawn(result: ExperimentResult) -> None:
    titles = [figure.title.partition(":")[0] for figure in result.figures]

    assert titles == [
        *("Fig. 6-10, clean", "Fig. 6-10, thesis", "Fig. 6-11, thesis"),
        *("Fig. 6-12a", "Fig. 6-12b", "Fig. 6-12c"),
    ]


def test_an_unknown_level_of_noise_is_refused() -> None:
    with pytest.raises(UsageError, match="--noise loud"):
        repeat_traction(PROFILE, SETUP, ("3a",), noise="loud")


@pytest.mark.thorough
def test_runs_by_the_engines_own_loops_are_compared_with_their_partners_too() -> None:
    assert SHIPPED.loops is not None
    loops = SHIPPED.loops.model_copy(update={"backend": "sim"})
    setup = SHIPPED.model_copy(update={"loops": loops})

    made = repeat_traction(PROFILE, setup, ("3a", "3b"), noise="clean")

    assert made.values["3b.sim.apart"] < 0.002
    assert abs(made.values["3b.sim.kept"]) < 0.03
    assert made.values["3b.clean.kept"] > 0.1
    assert [note.partition(":")[0] for note in made.notes[-2:]] == ["3a on sim", "3b on sim"]
