import numpy as np
import pytest

from pirate_sm.fitting.levenberg_marquardt import least_squares
from pirate_sm.simulation.arrays import Floats

X = np.linspace(0.0, 4.0, 60)
Y = 2.5 * np.exp(-1.3 * X) + 0.02 * np.random.default_rng(1).standard_normal(60)


def residuals(at: Floats) -> Floats:
    values: Floats = at[0] * np.exp(-at[1] * X) - Y
    return values


def test_the_parameters_are_those_of_scipy() -> None:
    optimize = pytest.importorskip("scipy.optimize")
    theirs = optimize.least_squares(residuals, [1.0, 1.0], method="lm")
    covariance = np.linalg.inv(theirs.jac.T @ theirs.jac) * 2 * theirs.cost / (60 - 2)

    ours = least_squares(residuals, np.array([1.0, 1.0]))

    assert ours.at == pytest.approx(theirs.x, rel=1e-5)
    assert ours.squares == pytest.approx(2 * theirs.cost, rel=1e-9)
    assert ours.covariance == pytest.approx(covariance, rel=1e-3)


def test_the_parameters_are_found_within_their_own_uncertainty() -> None:
    found = least_squares(residuals, np.array([1.0, 1.0]))

    assert np.abs(found.at - [2.5, 1.3]) == pytest.approx([0, 0], abs=0.05)
    assert (np.abs(found.at - [2.5, 1.3]) < 3 * np.sqrt(np.diag(found.covariance))).all()


def test_what_the_data_do_not_determine_has_an_infinite_covariance() -> None:
    found = least_squares(lambda at: at[:1] - np.array([3.0]), np.array([1.0, 1.0]))

    assert found.at[0] == pytest.approx(3.0)
    assert np.isinf(found.covariance).all()
