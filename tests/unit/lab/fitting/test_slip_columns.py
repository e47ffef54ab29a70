import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.fitting.measurements import SlipSignalNames, slip_and_friction, steady, wheels_in

COLUMNS = {
    "time_s": np.array([0.0, 1.0]),
    "slip_speed_1_m_per_s": np.array([0.01, 0.02]),
    "slip_speed_12_m_per_s": np.array([0.03, 0.04]),
    "used_1": np.array([0.1, 0.2]),
    "wheel_torque_1_Nm": np.array([0.012, -0.024]),
    "normal_force_1_N": np.array([5.0, 0.0]),
}


def test_wheels_are_found_by_the_name_of_their_slip() -> None:
    assert wheels_in(COLUMNS, SlipSignalNames()) == ["1", "12"]


def test_friction_comes_from_its_own_signal_where_one_is_named() -> None:
    slip, friction = slip_and_friction(COLUMNS, "1", SlipSignalNames(friction="used_{}"))

    assert slip.tolist() == [0.01, 0.02]
    assert friction.tolist() == [0.1, 0.2]


def test_friction_is_torque_over_radius_and_normal_force_and_unknown_without_pressure() -> None:
    _, friction = slip_and_friction(COLUMNS, "1", SlipSignalNames(radius_m=0.024))

    assert friction[0] == pytest.approx(0.1)
    assert np.isnan(friction[1])


def test_torques_without_a_radius_are_refused() -> None:
    with pytest.raises(UsageError, match="--radius"):
        slip_and_friction(COLUMNS, "1", SlipSignalNames())


def test_a_missing_signal_is_named() -> None:
    with pytest.raises(UsageError, match="no signal 'wheel_torque_12'"):
        slip_and_friction(COLUMNS, "12", SlipSignalNames(radius_m=0.024))


def test_columns_without_slip_are_refused() -> None:
    with pytest.raises(UsageError, match=r"no signal 'slide_\{\}'"):
        wheels_in(COLUMNS, SlipSignalNames(slip="slide_{}"))


def test_readings_count_once_both_have_kept_their_values_for_half_a_second() -> None:
    times = np.arange(0.0, 3.0, 0.1)
    slip = np.where(times < 1, 0.09 * times, 0.05) + 1e-5 * np.arange(30)

    kept, friction = steady(times, slip, np.full(30, 0.2))

    assert kept == pytest.approx(np.full(len(kept), 0.05), abs=1e-3)
    assert 13 <= len(kept) <= 16
    assert len(friction) == len(kept)


def test_repeated_and_unknown_readings_are_no_evidence() -> None:
    times = np.arange(0.0, 3.0, 0.1)

    assert len(steady(times, np.full(30, 0.05), np.full(30, 0.2))[0]) == 0
    assert len(steady(times, np.full(30, np.nan), np.full(30, 0.2))[0]) == 0
