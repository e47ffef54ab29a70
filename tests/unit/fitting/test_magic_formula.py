import numpy as np
import pytest

from pirate_sm.errors import UsageError
from pirate_sm.fitting.magic_formula import fit_magic, magic

X = np.geomspace(1e-4, 0.2, 40)
TRUE = np.array([180.0, 1.6, 0.55, 0.4])
Y = magic(X, TRUE)


def test_a_curve_of_the_family_is_found_again() -> None:
    fit = fit_magic(X, Y)

    assert fit(X) == pytest.approx(Y, abs=1e-6)
    assert fit.parameters == pytest.approx(TRUE, rel=1e-3)
    assert fit.misfit < 1e-6
    assert fit.limit == pytest.approx(0.55 * np.sin(0.8 * np.pi), rel=1e-3)


def test_the_fit_is_as_near_as_that_of_scipy() -> None:
    optimize = pytest.importorskip("scipy.optimize")
    noisy = Y + 0.01 * np.random.default_rng(3).standard_normal(len(X))
    theirs = optimize.least_squares(
        lambda at: magic(X, at) - noisy,
        TRUE,
        bounds=([0, 1, 0, -np.inf], [np.inf, 2, np.inf, 1]),
        x_scale=TRUE,
    )

    fit = fit_magic(X, noisy)

    assert fit.misfit == pytest.approx(np.sqrt(2 * theirs.cost / len(X)), rel=1e-3)
    assert fit(X) == pytest.approx(magic(X, theirs.x), abs=2e-3)


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
