"""Least squares by Levenberg and Marquardt's method (Marquardt 1963), with forward differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pirate_sm.simulation.arrays import Floats

_STEP = 1e-7
_MOST_STEPS = 200
_ENOUGH = 1e-12
"""A step that lessens the sum of squares by less than this share is the last one."""


class LeastSquares(NamedTuple):
    """Where the sum of squares is least.

    Attributes:
        at: The parameters.
        squares: The sum of squares.
        covariance: Of the parameters, from the residuals' own spread; infinite where the data do
            not determine them.
    """

    at: Floats
    squares: float
    covariance: Floats


def least_squares(residuals: Callable[[Floats], Floats], start: Floats) -> LeastSquares:
    """Return the parameters near ``start`` at which the residuals' sum of squares is least."""
    at, damping = np.array(start, dtype=np.float64), 1e-3
    here = residuals(at)
    squares = float(here @ here)
    for _ in range(_MOST_STEPS):
        slope = jacobian(residuals, at)
        curvature = slope.T @ slope
        while damping < 1e12:
            scaled = curvature + damping * np.diag(np.maximum(np.diag(curvature), 1e-12))
            tried = at - np.linalg.solve(scaled, slope.T @ here)
            there = residuals(tried)
            new = float(there @ there)
            if new < squares:
                break
            damping *= 4.0
        else:
            break
        gained, at, here, squares = squares - new, tried, there, new
        damping = max(damping / 8.0, 1e-12)
        if gained <= _ENOUGH * squares:
            break
    return LeastSquares(at, squares, _covariance(jacobian(residuals, at), squares))


def jacobian(function: Callable[[Floats], Floats], at: Floats) -> Floats:
    """Return the derivatives of a function, a column for each parameter."""
    here = function(at)
    columns = []
    for place, value in enumerate(at):
        moved = at.copy()
        moved[place] += (step := _STEP * max(abs(value), 1.0))
        columns.append((function(moved) - here) / step)
    return np.column_stack(columns)


def _covariance(slope: Floats, squares: float) -> Floats:
    rows, columns = slope.shape
    try:
        inverse = np.linalg.inv(slope.T @ slope)
    except np.linalg.LinAlgError:
        return np.full((columns, columns), np.inf)
    covariance: Floats = np.multiply(inverse, squares / max(rows - columns, 1))
    return covariance
