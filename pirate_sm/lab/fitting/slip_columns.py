"""Which columns hold slip and friction of each wheel, and what they are."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.fitting.columns import Columns, column, has
from pirate_sm.simulation.arrays import Floats

WHEEL = "{}"
"""Stands for the number of a wheel in the name of a signal."""

_STEADY_S, _STEADY_READINGS = 0.5, 3
_SHARE, _SLIP_PLAY_M_S, _FRICTION_PLAY = 0.33, 0.002, 0.01


@dataclass(frozen=True)
class SlipSignalNames:
    """Names of signals, with ``{}`` for the number of a wheel.

    Attributes:
        slip: Slip speeds, m/s.
        friction: Friction coefficients in use; empty: from torque and normal force.
        known: Friction coefficients that are known only where a wheel surely slips.
        torque: Wheel torques, Nm.
        normal: Normal forces, N.
        radius_m: Of the wheels, with torques.
    """

    slip: str = "slip_speed_{}"
    friction: str = ""
    torque: str = "wheel_torque_{}"
    normal: str = "normal_force_{}"
    radius_m: float = 0.0
    known: str = "mu_{}"


def wheels_in(columns: Columns, signals: SlipSignalNames) -> list[str]:
    """Return the numbers of the wheels whose slip is in the columns, in their order.

    Raises:
        UsageError: There is none.
    """
    before, _, after = signals.slip.partition(WHEEL)
    pattern = re.compile(rf"{re.escape(before)}(\d+){re.escape(after)}(?:_[A-Za-z_]\w*)?")
    found = [match[1] for name in columns if (match := pattern.fullmatch(name))]
    if not found and WHEEL not in signals.slip and has(columns, [signals.slip]):
        return [""]
    if not found:
        raise UsageError(
            f"there is no signal '{signals.slip}' with the number of a wheel for {WHEEL}: "
            "name the signals of slip and friction with --slip and --friction"
        )
    return sorted(dict.fromkeys(found), key=int)


def steady(times_s: Floats, slip: Floats, friction: Floats) -> tuple[Floats, Floats]:
    """Return slip and friction where both have kept their values for half a second.

    Readings of a robot come one after the other: while a wheel speeds up or the robot bumps, its
    slip, its torque and the force on it belong to different moments.
    """
    known = np.isfinite(slip) & np.isfinite(friction)
    times_s, slip, friction = times_s[known], slip[known], friction[known]
    fresh = np.concatenate([[True], (np.diff(slip) != 0) | (np.diff(friction) != 0)])[: len(slip)]
    times_s, slip, friction = times_s[fresh], slip[fresh], friction[fresh]
    begins = np.searchsorted(times_s, times_s - _STEADY_S)
    kept = [
        end - begin >= _STEADY_READINGS
        and _keeps(slip[begin : end + 1], _SLIP_PLAY_M_S)
        and _keeps(friction[begin : end + 1], _FRICTION_PLAY)
        for end, begin in enumerate(begins)
    ]
    return slip[kept], friction[kept]


def _keeps(values: Floats, play: float) -> bool:
    """Return whether values differ by no more than a third of their size, or by some play."""
    return bool(np.ptp(values) <= max(_SHARE * abs(float(np.median(values))), play))


def slip_and_friction(
    columns: Columns, wheel: str, signals: SlipSignalNames
) -> tuple[Floats, Floats]:
    """Return slip speeds and friction coefficients of a wheel, in the order of time.

    Raises:
        UsageError: A signal is missing, or nothing is known of it.
    """
    slip = column(columns, signals.slip.replace(WHEEL, wheel))
    if signals.friction:
        return slip, column(columns, signals.friction.replace(WHEEL, wheel))
    torque = column(columns, signals.torque.replace(WHEEL, wheel))
    normal = column(columns, signals.normal.replace(WHEEL, wheel))
    if signals.radius_m <= 0:
        raise UsageError("friction from torques needs the radius of the wheels: --radius 24mm")
    pressed = np.where(normal > 0, normal, np.nan)
    friction: Floats = np.abs(torque) / signals.radius_m / pressed
    return slip, friction
