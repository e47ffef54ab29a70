from math import isnan

import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.fitting.slip_curve import fit_slip_curve, medians
from pirate_sm.simulation.arrays import Floats


def law(slip: Floats) -> Floats:
    """Fig. 4-3 with 0.3, 0.2 and 1 mm/s."""
    values: Floats = np.interp(np.abs(slip), [0, 0.001, 0.0015, 1.0], [0, 0.3, 0.2, 0.2])
    return values


def points(least: float, most: float, count: int = 6000) -> tuple[Floats, Floats]:
    random = np.random.default_rng(2)
    slip = random.choice([-1, 1], count) * np.exp(
        random.uniform(np.log(least), np.log(most), count)
    )
    return slip, law(slip) + 0.002 * random.standard_normal(count)


def test_peak_and_plateau_are_found_directly_within_two_percent() -> None:
    curve = fit_slip_curve(*points(1e-4, 0.05), threshold=0.001)

    assert curve.static.value == pytest.approx(0.3, rel=0.02)
    assert curve.kinetic.value == pytest.approx(0.2, rel=0.02)
    assert curve.kinetic.low <= 0.2 <= curve.kinetic.high


def test_the_process_follows_the_peak_and_the_magic_formula_says_by_how_much_it_does_not() -> None:
    curve = fit_slip_curve(*points(1e-4, 0.05), threshold=0.001)

    assert curve.process_peak.value == pytest.approx(0.3, rel=0.025)
    assert curve.magic_plateau.value == pytest.approx(0.2, rel=0.05)
    assert curve.magic_peak.value < 0.28
    assert curve.magic is not None
    assert curve.magic.misfit > 0.005


def test_a_plateau_is_refused_without_points_that_surely_slip() -> None:
    curve = fit_slip_curve(*points(1e-4, 0.004), threshold=0.001)

    assert not curve.kinetic.known
    assert curve.kinetic.reason == "0 points above 5 mm/s of slip, a plateau needs 20"
    assert not curve.magic_plateau.known
    assert curve.static.known


@pytest.mark.thorough
def test_without_slip_only_a_bound_of_friction_is_known() -> None:
    curve = fit_slip_curve(*points(1e-5, 5e-4), threshold=0.001)

    assert isnan(curve.static.value)
    assert curve.static.low == pytest.approx(0.15, abs=0.01)
    assert "friction may be higher" in curve.static.reason


def test_a_peak_is_refused_where_no_point_is_near_it() -> None:
    slip, friction = points(1e-4, 0.05)
    far = np.abs(np.log(np.abs(slip) / 0.001)) > 0.5

    curve = fit_slip_curve(slip[far], friction[far], threshold=0.001)

    assert curve.static.reason == "too few points around the peak"


def test_without_a_threshold_it_is_where_friction_is_highest() -> None:
    curve = fit_slip_curve(*points(1e-4, 0.05))

    assert curve.static.value == pytest.approx(0.3, rel=0.03)


def test_unknown_values_do_not_count() -> None:
    slip, friction = points(1e-4, 0.05)
    friction[::2] = np.nan

    assert fit_slip_curve(slip, friction).points == len(slip) // 2


def test_nothing_known_is_refused() -> None:
    with pytest.raises(UsageError, match="never known at the same time"):
        fit_slip_curve(np.array([0.1, np.nan]), np.array([np.nan, 0.2]))


def test_a_wheel_at_rest_gives_no_curve() -> None:
    curve = fit_slip_curve(np.zeros(50), np.full(50, 0.1))

    assert curve.magic is None
    assert curve.process is None
    assert not curve.static.known


def test_medians_are_in_bins_equally_wide_in_log_slip() -> None:
    slip, friction = medians(*points(1e-4, 0.05), count=30)

    steps = np.diff(np.log(slip))
    assert len(slip) == 30
    assert steps == pytest.approx(np.full(29, np.log(500) / 30), rel=0.5)
    assert friction == pytest.approx(law(slip), abs=0.02)
