"""Compare times that differ by rounding."""

from __future__ import annotations

ROUNDING_S = 1e-9
"""Sums of times differ by rounding; a deadline that is so near has come. Without it a deadline
could be due for who sets the alarm and not yet for who is woken by it."""


def has_come(now: float, at_s: float) -> bool:
    """Whether ``at_s`` is now or past."""
    return now >= at_s - ROUNDING_S
