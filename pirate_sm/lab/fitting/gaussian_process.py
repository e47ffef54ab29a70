"""Gaussian processes with a squared exponential covariance (thesis eq. 2-14 to 2-22, corrected).

Equation 2-21 lacks the inverse of the covariance, 2-22 has the wrong sign before its noise. Values
are centred; log σ_f, log l and log σ_n are those of the greatest likelihood, found along the
analytic gradient (Rasmussen and Williams 2006, eq. 5.9).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pirate_sm.core.errors import UsageError, not_installed
from pirate_sm.simulation.arrays import Floats

try:
    from scipy.optimize import Bounds, minimize
except ModuleNotFoundError:
    raise not_installed("a curve of slip and friction", "scipy", "fit") from None

_FLAT, _ENOUGH = 1e-6, 1e-14
"""The search ends where the gradient of the log likelihood is below the first, or where a step
raises it by less than the second, as a share."""

_BELOW, _ABOVE = np.array([7.0, 5.0, 9.0]), np.array([7.0, 5.0, 7.0])
"""How far the logs are searched to each side of the start."""

_LEAST_NOISE = 1e-10
"""Variance added for the sake of the arithmetic, over that of the curve."""


@dataclass(frozen=True)
class GaussianProcess:
    """A process that was given points.

    Attributes:
        x: Where its points lie.
        mean: What was subtracted from their values.
        logs: log σ_f, log l, log σ_n.
        likelihood: Log marginal likelihood.
        factor: Lower triangle of the covariance's Cholesky decomposition.
        weights: The covariance's inverse times the centred values.
    """

    x: Floats
    mean: float
    logs: Floats
    likelihood: float
    factor: Floats
    weights: Floats

    def __call__(self, x: Floats) -> tuple[Floats, Floats]:
        """Return mean and standard deviation of the curve, without its noise (eq. 2-21, 2-22)."""
        across = _covariance(self.x, x, self.logs)
        halfway = np.linalg.solve(self.factor, across)
        variance = np.exp(2 * self.logs[0]) - np.sum(halfway**2, axis=0)
        return self.mean + across.T @ self.weights, np.sqrt(np.maximum(variance, 0.0))


def fit_process(x: Floats, y: Floats) -> GaussianProcess:
    """Return the Gaussian process of the points.

    Args:
        x: Where they lie.
        y: Their values, with white noise.

    Raises:
        UsageError: There are fewer than three points.
    """
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if len(x) < 3:
        raise UsageError(f"a Gaussian process needs at least 3 points, got {len(x)}")
    spread, width = max(float(np.std(y)), 1e-9), max(float(np.ptp(x)), 1e-9)
    starts = [np.log([spread, share * width, 0.1 * spread]) for share in (0.03, 0.1, 0.3)]
    centred = y - np.mean(y)
    tops = [_climb(x, centred, start) for start in starts]
    logs = max(tops, key=lambda each: _likelihood(x, centred, each)[0])
    likelihood, _, factor, weights = _likelihood(x, centred, logs)
    return GaussianProcess(x, float(np.mean(y)), logs, likelihood, factor, weights)


def _covariance(one: Floats, other: Floats, logs: Floats) -> Floats:
    """Return the covariances between two sets of places (eq. 2-14)."""
    apart = (np.asarray(one)[:, None] - np.asarray(other)[None, :]) / np.exp(logs[1])
    covariance: Floats = np.exp(2 * logs[0] - 0.5 * apart**2)
    return covariance


def _likelihood(x: Floats, y: Floats, logs: Floats) -> tuple[float, Floats, Floats, Floats]:
    """Return log likelihood, its gradient, the Cholesky factor and the weights."""
    clean = _covariance(x, x, logs)
    noise = np.exp(2 * logs[2])
    extra = _LEAST_NOISE * np.exp(2 * logs[0])
    factor: Floats = np.linalg.cholesky(clean + (noise + extra) * np.eye(len(x)))
    inverse = np.linalg.inv(factor)
    precision = inverse.T @ inverse
    weights: Floats = precision @ y
    likelihood = -0.5 * (y @ weights) - np.sum(np.log(np.diag(factor)))
    likelihood -= 0.5 * len(x) * np.log(2 * np.pi)
    pull = np.outer(weights, weights) - precision
    apart = (x[:, None] - x[None, :]) ** 2 / np.exp(2 * logs[1])
    gradient = np.array(
        [np.sum(pull * clean), 0.5 * np.sum(pull * clean * apart), noise * np.trace(pull)]
    )
    return float(likelihood), gradient, factor, weights


def _climb(x: Floats, y: Floats, start: Floats) -> Floats:
    """Return the logs of the parameters at a top of the likelihood."""

    def downhill(logs: Floats) -> tuple[float, Floats]:
        try:
            likelihood, gradient, *_ = _likelihood(x, y, logs)
        except np.linalg.LinAlgError:
            return np.inf, np.zeros(3)
        return -likelihood, -gradient

    # A length of far more or less than what the points span, or no noise, says nothing more.
    bounds = Bounds(start - _BELOW, start + _ABOVE)
    options = {"gtol": _FLAT, "ftol": _ENOUGH}
    found = minimize(downhill, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(found.x, dtype=np.float64)
