import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.fitting.slip_curve import fit_process

RANDOM = np.random.default_rng(5)
X = np.sort(RANDOM.uniform(-3.0, 3.0, 90))
Y = 0.4 + np.sin(2 * X) * np.exp(-(X**2) / 6) + 0.05 * RANDOM.standard_normal(90)
GRID = np.linspace(-3.0, 3.0, 101)


@pytest.mark.thorough
def test_likelihood_and_curve_are_those_of_scikit_learn() -> None:
    judge = pytest.importorskip("sklearn.gaussian_process")
    kernels = judge.kernels
    kernel = kernels.ConstantKernel(1.0) * kernels.RBF(1.0) + kernels.WhiteKernel(0.01)
    theirs = judge.GaussianProcessRegressor(kernel, n_restarts_optimizer=3, random_state=0)
    theirs.fit(X[:, None], Y - Y.mean())
    mean, total = theirs.predict(GRID[:, None], return_std=True)
    noise = theirs.kernel_.k2.noise_level

    ours = fit_process(X, Y)
    curve, deviation = ours(GRID)

    assert ours.likelihood == pytest.approx(theirs.log_marginal_likelihood_value_, abs=1e-4)
    assert curve == pytest.approx(mean + Y.mean(), abs=1e-5)
    assert deviation == pytest.approx(np.sqrt(total**2 - noise), abs=1e-4)
    assert np.exp(2 * ours.logs[2]) == pytest.approx(noise, rel=1e-3)


def test_the_noise_is_found_and_the_curve_lies_within_its_band() -> None:
    process = fit_process(X, Y)
    curve, deviation = process(X)
    true = 0.4 + np.sin(2 * X) * np.exp(-(X**2) / 6)

    assert np.exp(process.logs[2]) == pytest.approx(0.05, rel=0.2)
    assert np.mean(np.abs(curve - true) < 2 * deviation + 1e-3) > 0.9


def test_far_from_the_points_nothing_is_known() -> None:
    process = fit_process(X, Y)

    curve, deviation = process(np.array([40.0]))

    assert curve[0] == pytest.approx(Y.mean(), abs=1e-9)
    assert deviation[0] == pytest.approx(np.exp(process.logs[0]))


def test_points_without_noise_are_met() -> None:
    x = np.linspace(0.0, 1.0, 12)

    process = fit_process(x, x**2)

    assert process(x)[0] == pytest.approx(x**2, abs=1e-3)


def test_two_points_are_refused() -> None:
    with pytest.raises(UsageError, match="at least 3 points, got 2"):
        fit_process(X[:2], Y[:2])
