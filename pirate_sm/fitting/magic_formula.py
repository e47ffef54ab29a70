"""The Magic formula (thesis eq. 2-4 to 2-6) and its fit; shifts are 0, C 1 to 2, E at most 1."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import pi, sin, sqrt

import numpy as np

from pirate_sm.errors import UsageError
from pirate_sm.fitting.levenberg_marquardt import LeastSquares, jacobian, least_squares
from pirate_sm.simulation.arrays import Floats

NAMES = ("B", "C", "D", "E")
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
    starts = product((0.3 / middle, 3.0 / middle, 30.0 / middle), (0.0, 2.0))
    fits = [
        least_squares(
            lambda free: magic(x, _bounded(free)) - y,
            np.array([np.log(stiffness), 0.0, np.log(most), bend]),
        )
        for stiffness, bend in starts
    ]
    return _formula(min(fits, key=lambda each: each.squares), len(x))


def _bounded(free: Floats) -> Floats:
    """Return B > 0, 1 < C < 2, D > 0 and E < 1 of four numbers that may be anything."""
    stiffness, shape, peak, bend = np.clip(free, -40.0, 40.0)
    return np.array(
        [np.exp(stiffness), 1.0 + 1.0 / (1.0 + np.exp(-shape)), np.exp(peak), 1.0 - np.exp(bend)]
    )


def _formula(found: LeastSquares, count: int) -> MagicFormula:
    slope = jacobian(_bounded, found.at)
    # What is at a bound has no slope there: the data do not determine it.
    spread = np.einsum("ij,jk,ik->i", slope, found.covariance, slope)
    known = np.isfinite(spread) & (spread >= 0)
    interval = np.where(known, _SURE * np.sqrt(np.where(known, spread, 0.0)), np.inf)
    return MagicFormula(_bounded(found.at), interval, sqrt(found.squares / count))
