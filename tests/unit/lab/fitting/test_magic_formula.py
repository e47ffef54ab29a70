import numpy as np
import pytest
from scipy import optimize

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.fitting.slip_curve import fit_magic, magic

X = np.geomspace(1e-4, 0.2, 40)
TRUE = np.array([180.0, 1.6, 0.55, 0.4])
Y = magic(X, TRUE)


def test_a_curve_of_the_family_is_found_again() -> None:
    fit = fit_magic(X, Y)

    assert fit(X) == pytest.approx(Y, abs=1e-6)
    assert fit.parameters == pytest.approx(TRUE, rel=1e-3)
    assert fit.misfit < 1e-6
    assert fit.limit == pytest.approx(0.55 * np.sin(0.8 * np.pi), rel=1e-3)


def test_no_better_fit_is_found_from_the_true_parameters() -> None:
    noisy = Y + 0.01 * np.random.default_rng(3).standard_normal(len(X))
    theirs = optimize.least_squares(lambda at: magic(X, at) - noisy, TRUE, x_scale=TRUE)

    fit = fit_magic(X, noisy)

    assert fit.misfit == pytest.approx(np.sqrt(2 * theirs.cost / len(X)), rel=1e-3)
    assert fit(X) == pytest.approx(magic(X, theirs.x), abs=2e-3)


def test_the_intervals_hold_the_true_parameters() -> None:
    fit = fit_magic(X, Y + 0.01 * np.random.default_rng(3).standard_normal(len(X)))

    assert (np.abs(fit.parameters - TRUE) < fit.interval).all()
    assert fit.interval[2] == pytest.approx(0.01, abs=0.009)


@pytest.mark.thorough
def test_the_points_of_a_line_do_not_determine_where_it_would_bend() -> None:
    fit = fit_magic(X, 0.4 * X / 0.2 + 1e-3 * np.random.default_rng(3).standard_normal(len(X)))

    assert fit.interval[0] > fit.parameters[0]


@pytest.mark.thorough
def test_parameters_stay_within_what_the_formula_allows() -> None:
    fit = fit_magic(X, 0.4 * X / 0.2)
    stiffness, shape, peak, curvature = fit.parameters

    assert stiffness > 0
    assert 1 <= shape <= 2
    assert peak > 0
    assert curvature <= 1


def test_fewer_points_than_parameters_are_refused() -> None:
    with pytest.raises(UsageError, match="more than 4 points, got 3"):
        fit_magic(X[:3], Y[:3])


def test_a_curve_that_hardly_bends_is_found_again() -> None:
    fit = fit_magic(X, magic(X, np.array([5.0, 1.3, 0.3, -1.0])))

    assert fit.parameters == pytest.approx([5.0, 1.3, 0.3, -1.0], rel=1e-3)
    assert fit.misfit < 1e-8
