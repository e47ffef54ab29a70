import numpy as np
import pytest

from pirate_sm.lab.fitting.slip_curve import fit_slip_curve, slip_plot


@pytest.mark.thorough
def test_both_fits_and_the_band_are_drawn_over_the_points() -> None:
    slip = np.geomspace(1e-4, 0.05, 400)
    friction = 0.3 * np.tanh(slip / 0.001)

    plot = slip_plot(fit_slip_curve(slip, friction), "all")

    assert [each.look for each in plot.series] == ["band", "dots", "line", "line"]
    assert plot.log_x


def test_points_without_a_fit_are_drawn_alone() -> None:
    plot = slip_plot(fit_slip_curve(np.full(9, 0.01), np.full(9, 0.2)), "all")

    assert [each.look for each in plot.series] == ["dots"]
