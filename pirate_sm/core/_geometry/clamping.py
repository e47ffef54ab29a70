"""Clamp statics: the geometry of a V between the walls, and its contact forces.

The clamp force of a part is tau / sqrt(l^2 - h^2) * (1, 2, 1) on the three wheels of its V
(thesis eq. 3-3) with h = diameter - 2 r (eq. 3-2). Friction must bear m g sin(alpha) (eq. 3-14).
Equations 3-24 and 3-25, which combine the two, are not used: as printed they change sign where
tan(alpha) is half the friction coefficient.
"""

from __future__ import annotations

from math import inf, sin, sqrt

WHEELS_SHARE = 4.0
"""Sum of the wheels' shares (1, 2, 1) in a part's clamp force (eq. 3-3)."""


HELD_SAFETY = 1.25
"""By this factor a part that holds alone presses harder than friction asks for [decided]."""


def height_m(leg_m: float, apex_rad: float) -> float:
    """Return the height h of a V with legs of one length whose apex has this angle (eq. 3-2)."""
    return abs(leg_m * sin(apex_rad / 2))


def span_m(leg_m: float, height_m: float) -> float:
    """Return the length along the pipe of a link from wall to wall, m; 0 if it is too short."""
    return sqrt(max(leg_m * leg_m - height_m * height_m, 0.0))


def press_n(torque_nm: float, leg_m: float, height_m: float) -> float:
    """Return the sum of the normal forces of a V whose apex has this torque (eq. 3-3)."""
    lever = span_m(leg_m, height_m)
    return WHEELS_SHARE * torque_nm / lever if lever > 0 else inf


def holding_nm(pull_n: float, friction: float, leg_m: float, height_m: float) -> float:
    """Return the torque at the apex of a V that alone bears a pull along the pipe (eq. 3-3, 3-14).

    Args:
        pull_n: The pull.
        friction: Static friction of its wheels.
        leg_m: Length of its legs.
        height_m: Height of the V.
    """
    pressed_n = HELD_SAFETY * pull_n / friction if friction > 0 else inf
    return pressed_n * span_m(leg_m, height_m) / WHEELS_SHARE
