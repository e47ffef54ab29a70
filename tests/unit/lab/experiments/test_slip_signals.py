import numpy as np
import pytest

import pirate_sm
from pirate_sm.lab.experiments.setups import PostProcessing
from pirate_sm.lab.experiments.straight_pipe import SlipSignals

PROCESSING = PostProcessing(
    step=0.01, window=1.0, still_below=0.005, driving_above=0.08, most_ratio=1.0, every=10
)


@pytest.fixture(scope="module")
def signals() -> SlipSignals:
    return SlipSignals(pirate_sm.run("climb"), PROCESSING)


def test_rims_go_as_fast_as_the_robot_where_wheels_do_not_slip(signals: SlipSignals) -> None:
    wheels = signals.run.loaded.loaded_robot.profile.body.wheels
    moving = np.abs(signals.speed_m_s) > 0.05

    assert np.count_nonzero(moving) > 100
    for wheel in wheels:
        assert np.median(np.abs(signals.slip_m_s(wheel)[moving])) < 0.005


def test_the_slip_ratio_is_unknown_at_rest(signals: SlipSignals) -> None:
    wheel = signals.run.loaded.loaded_robot.profile.body.wheels[0]
    resting = np.abs(signals.speed_m_s) < 0.005

    assert resting.any()
    assert np.isnan(signals.ratio(wheel)[resting]).all()
    assert np.isfinite(signals.ratio(wheel)[~resting]).all()


def test_the_middle_wheel_of_a_clamp_is_pressed_twice_as_hard(signals: SlipSignals) -> None:
    first, second, *_ = signals.run.loaded.loaded_robot.profile.body.wheels

    assert signals.normal_n(second) == pytest.approx(2 * signals.normal_n(first))
