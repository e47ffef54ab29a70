"""Setpoints as the integers of the wire, within the limits of their slots."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple

Integers = tuple[int, ...]

_ROUNDING = 1e-6


class WireSlot(NamedTuple):
    """How one setpoint is written, and its limit, checked here once more.

    Attributes:
        resolution: Value of one count.
        limit: Largest magnitude, in the slot's own unit.
    """

    name: str
    resolution: float
    limit: float


def why_refused(slots: Sequence[WireSlot], values: Sequence[float]) -> str:
    """Return why this array must not be sent; empty if it may (thesis section 4-2-1)."""
    if len(values) != len(slots):
        return f"{len(values)} values for {len(slots)} slots"
    for slot, value in zip(slots, values, strict=True):
        if not isfinite(value):
            return f"{slot.name} is no number"
        if abs(value) > slot.limit + _ROUNDING:
            return f"{slot.name} = {value:g} is beyond its limit of {slot.limit:g}"
    return ""


def to_counts(slots: Sequence[WireSlot], values: Sequence[float]) -> Integers:
    """Return the array as counts of the wire."""
    pairs = zip(slots, values, strict=True)
    return tuple(round(value / slot.resolution) for slot, value in pairs)
