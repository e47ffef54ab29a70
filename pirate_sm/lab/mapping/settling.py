"""What is found of bends once the legs on either side are known: angles by gravity, radii."""

from __future__ import annotations

from math import acos, atan2, hypot, isnan, pi, remainder, sin

from pirate_sm.core.geometry import dot
from pirate_sm.lab.mapping.bores import diameter_of
from pirate_sm.lab.mapping.legs import Map, middle

_UPRIGHT = 0.9
"""The least share of gravity in the plane of a bend whose angle pitch shows (25 deg) [decided]."""


def feel_angles(made: Map) -> None:
    """Take the angles of bends in an upright plane from the pitches of their legs."""
    first = made.start[0]
    for number in (*range(first, len(made.bends)), *range(first - 1, -1, -1)):
        near, far = (number, number + 1) if number >= first else (number + 1, number)
        bend, frame = made.bends[number], made.frame(near)
        along = dot(frame.ahead, made.up)
        towards = (far - near) * dot(frame.towards(bend.roll_rad), made.up)
        share, pitch_rad = hypot(along, towards), middle(made.legs[far].pitches_rad)
        if isnan(made.pitch_rad) or isnan(pitch_rad) or share < _UPRIGHT:
            continue
        off_rad = acos(max(-1.0, min(1.0, sin(pitch_rad) / share)))
        both = (abs(remainder(atan2(towards, along) + it, 2 * pi)) for it in (off_rad, -off_rad))
        bend.angle_rad = min(both, key=lambda angle: abs(angle - bend.angle_rad))
        bend.felt = True


def round_elbows(made: Map) -> None:
    """Find the radii of elbows, and let the legs beside them end where they begin."""
    for number, bend in enumerate(made.bends):
        behind, ahead = made.legs[number : number + 2]
        diameter_m = diameter_of(ahead.bores) or diameter_of(behind.bores)
        if bend.is_round and diameter_m is not None:
            bend.radius_m = bend.arc_m(diameter_m) / bend.angle_rad
            behind.ends_m -= bend.wall_m(diameter_m)
            ahead.begins_m += bend.wall_m(diameter_m)
