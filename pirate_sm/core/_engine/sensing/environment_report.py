"""Environment reports: whether two differ by more than noise, and how two become one."""

from __future__ import annotations

from math import inf, isnan, nan, pi, radians, remainder

from pirate_sm.core._model.effects import Environment

NOTHING_AROUND = Environment("", nan, nan, nan)

NOISE_RAD, NOISE_M, _NOISE_WAY_M = radians(1), 1e-3, 0.1
"""Smaller changes are not reported."""


def merged(derived: Environment, outside: Environment) -> Environment:
    """Return the report from outside, with what it does not know as it was derived."""
    known = {
        name: value
        for name, value in outside._asdict().items()
        if (not isnan(value) if isinstance(value, float) else value)
    }
    return derived._replace(**known)


def differs(old: Environment, new: Environment) -> bool:
    """Return whether two reports differ by more than noise."""
    return (
        (old.segment, old.joint, old.junction, old.run)
        != (new.segment, new.joint, new.junction, new.run)
        or _has_moved(old.roll_rad, new.roll_rad, NOISE_RAD, turn=2 * pi)
        or _has_moved(old.pitch_rad, new.pitch_rad, NOISE_RAD)
        or _has_moved(old.opening_roll_rad, new.opening_roll_rad, NOISE_RAD, turn=2 * pi)
        or _has_moved(old.diameter_m, new.diameter_m, NOISE_M)
        or _has_moved(old.diameter_ahead_m, new.diameter_ahead_m, NOISE_M)
        or _has_moved(old.distance_m, new.distance_m, _NOISE_WAY_M)
        or _has_moved(old.arc_m, new.arc_m, _NOISE_WAY_M)
    )


def _has_moved(old: float, new: float, noise: float, turn: float = inf) -> bool:
    """Return whether a value has changed by more than noise, or became known or unknown."""
    if isnan(old) or isnan(new):
        return isnan(old) != isnan(new)
    return abs(remainder(new - old, turn)) > noise
