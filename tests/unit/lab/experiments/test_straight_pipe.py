from pathlib import Path

import pytest

from pirate_sm.core.loading import load_robot
from pirate_sm.lab.experiments.experiment_files import load_experiments
from pirate_sm.lab.experiments.setups import ExperimentResult, StraightPipeSetup
from pirate_sm.lab.experiments.straight_pipe import repeat_straight_pipe

ROBOT = Path(__file__).parents[4] / "hardware_profiles" / "pirate_ii"
WHEELS = ("wheel_1", "wheel_2", "wheel_5", "wheel_6")

pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module")
def result() -> ExperimentResult:
    (setup,) = (each for each in load_experiments(ROBOT) if isinstance(each, StraightPipeSetup))
    again = {"1d": setup.again["1d"].model_copy(update={"backend": "sim"})}
    seen = {"1d": str(ROBOT.parents[1] / "tests" / "cameras" / "small_straight.yaml")}
    once_more = setup.model_copy(update={"again": again, "seen": seen})
    return repeat_straight_pipe(load_robot(ROBOT).profile, once_more, ("1a", "1d"))


@pytest.mark.parametrize("part", ["1a", "1d", "1d.sim", "1d.seen"])
def test_wheels_hardly_slip_in_driving(result: ExperimentResult, part: str) -> None:
    slips = {wheel: result.values[f"{part}.{wheel}.driving_median"] for wheel in WHEELS}

    assert all(abs(slip) < 0.05 for slip in slips.values()), slips


def test_wheels_slip_where_the_pipe_is_blocked(result: ExperimentResult) -> None:
    assert result.values["1a.wheel_1.least"] < -0.4
    assert result.values["1d.wheel_1.least"] > -0.4


def test_the_figures_of_the_part_shown_are_drawn(result: ExperimentResult) -> None:
    titles = [figure.title.partition(":")[0] for figure in result.figures]

    assert list(dict.fromkeys(titles)) == [
        "Table 6-1, 1a",
        *(f"Fig. 6-{number}" for number in range(1, 9)),
        "Table 6-1, 1d",
    ]
