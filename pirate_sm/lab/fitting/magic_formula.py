"""The Magic formula (thesis eq. 2-4 to 2-6) and its fit; shifts are 0, C 1 to 2, E at most 1."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import pi, sin, sqrt

import numpy as np

from pirate_sm.core.errors import UsageError, not_installed
from pirate_sm.simulation.arrays import Floats

try:
    from scipy.optimize import least_squares
except ModuleNotFoundError:
    raise not_installed("a curve of slip and friction", "scipy", "fit") from None

NAMES = ("B", "C", "D", "E")
_BOUNDS = (0.0, 1.0, 0.0, -np.inf), (np.inf, 2.0, np.inf, 1.0)
_SURE = 1.96
"""Standard deviations that hold 95 % of a normal distribution."""


@dataclass(frozen=True)
class MagicFormula:
    """A fitted curve y = D sin(C atan(B x − E (B x − atan(B x)))).

    Attributes:
        parameters: B, C, D, E.
        interval: Half the width of each parameter's 95 % interval; infinite where the data do not
            determine it.
        misfit: Root mean square of what the curve is off by.
    """

    parameters: Floats
    interval: Floats
    misfit: float

    def __call__(self, x: Floats) -> Floats:
        """Return the curve's values."""
        return magic(x, self.parameters)

    @property
    def limit(self) -> float:
        """The value that the curve comes to where x is large."""
        _, shape, peak, curvature = self.parameters
        return float(peak * sin(shape * pi / 2)) if curvature < 1 else float("nan")


def magic(x: Floats, parameters: Floats) -> Floats:
    """Return the Magic formula's values for B, C, D, E."""
    stiffness, shape, peak, curvature = parameters
    scaled = stiffness * np.asarray(x, dtype=np.float64)
    bent = scaled - curvature * (scaled - np.arctan(scaled))
    values: Floats = peak * np.sin(shape * np.arctan(bent))
    return values


def fit_magic(x: Floats, y: Floats) -> MagicFormula:
    """Return the Magic formula that is nearest to the points by least squares.

    Args:
        x: Slip, not negative: its speed, or −λ.
        y: Friction, not negative.

    Raises:
        UsageError: There are fewer points than a curve of four parameters needs.
    """
    if len(x) <= len(NAMES):
        raise UsageError(f"a Magic formula needs more than {len(NAMES)} points, got {len(x)}")
    middle, most = float(np.median(x)), max(float(np.max(y)), 1e-6)
    starts = product((0.3 / middle, 3.0 / middle, 30.0 / middle), (1.5,), (most,), (0.0, -6.4))
    fits = [
        least_squares(lambda at: magic(x, at) - y, start, bounds=_BOUNDS, x_scale="jac")
        for start in starts
    ]
    best = min(fits, key=lambda each: float(each.cost))
    squares = 2.0 * float(best.cost)
    return MagicFormula(best.x, _interval(best.jac, squares), sqrt(squares / len(x)))


def _interval(slope: Floats, squares: float) -> Floats:
    """Return half the width of each parameter's interval, from the residuals' own spread."""
    rows, columns = slope.shape
    try:
        variance = np.diag(np.linalg.inv(slope.T @ slope)) * squares / (rows - columns)
    except np.linalg.LinAlgError:
        return np.full(columns, np.inf)
    return np.where(variance >= 0, _SURE * np.sqrt(np.abs(variance)), np.inf)
