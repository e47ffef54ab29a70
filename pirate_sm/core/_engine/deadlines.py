"""Compare times that differ by rounding."""

from __future__ import annotations

ROUNDING_S = 1e-9
"""Tolerance of time comparisons. Sums of times differ by rounding: without a tolerance, a deadline
could be due for the clock that wakes the engine, and not yet for the engine."""


def has_come(now: float, at_s: float) -> bool:
    """Return whether the time ``at_s`` has been reached, within rounding."""
    return now >= at_s - ROUNDING_S
