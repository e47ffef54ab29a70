"""The angle of a bend whose place words give, from the joint angles."""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, radians

from pirate_sm.core.geometry import Frame, between, combined, dot
from pirate_sm.core.sensing import BodySpec, axis_at, wheel_at
from pirate_sm.lab.mapping.leg_meetings import angle_between, outermost
from pirate_sm.lab.mapping.legs import MappedBend
from pirate_sm.lab.mapping.looks import RobotLook

_BESIDE_RAD = radians(4)
"""The slope of a link and its direction from the corner agree up to this angle, unless the part
is off the axis of a round pipe: then the link is less oblique [decided]."""

_MOST_SHARE = 0.8
"""A part that is farther into an elbow does not show its angle [decided]."""

_ROUNDS = 9
"""Walls of an elbow's ends depend on its angle, and that on them: it converges [decided]."""


def angle_of_corner(
    body: BodySpec,
    numbers: Sequence[float],
    corner: Frame,
    part: int,
    leads: int,
    sloping_rad: float,
) -> float:
    """Return the angle of a corner, rad, by the direction from it to a part that has gone first.

    The middle of its outermost link is on the axis of the other leg also where the link is not
    oblique enough. Where the link's own slope agrees, both count.

    Args:
        body: The robot's chain.
        numbers: Every signal in SI.
        corner: The axis of the leg behind, at the corner.
        part: The part that has gone first.
        leads: 1 if that is the front part, -1 if it is the rear part.
        sloping_rad: The angle as the link's slope shows it.
    """
    wheels = outermost(body, part, leads)
    places = [wheel_at(body, numbers, wheel) for wheel in wheels]
    halfway = combined(*((1 / len(places), place) for place in places))
    away = between(corner.origin, halfway)
    cosine = leads * dot(away, corner.ahead) / dot(away, away) ** 0.5
    seen_rad = acos(max(-1.0, min(1.0, cosine)))
    alike = abs(seen_rad - sloping_rad) < _BESIDE_RAD
    return (seen_rad + sloping_rad) / 2 if alike else seen_rad


def angle_of_elbow(
    body: BodySpec,
    numbers: Sequence[float],
    elbow: MappedBend,
    parts: tuple[int, int],
    into_m: float,
    diameter_m: float,
) -> float:
    """Return an estimate of the angle of an elbow in which the part that comes last stands, rad.

    The axes at the two parts differ by what the last part has not been turned yet: its share of the
    angle is that of the elbow's length which is ahead of it. An error of 10 mm is one of 5 deg.

    Args:
        body: The robot's chain.
        numbers: Every signal in SI.
        elbow: The elbow, with its extent.
        parts: The part that has left it, and the part that stands in it.
        into_m: How far the middle of the last part is beyond the place that words count from.
        diameter_m: The inner diameter.
    """
    first, last = (axis_at(body, numbers, part) for part in parts)
    if first is None or last is None:
        return elbow.angle_rad
    found = elbow
    for _ in range(_ROUNDS):
        share = (into_m + found.wall_m(diameter_m)) / found.arc_m(diameter_m)
        ahead = 1.0 - min(max(share, 0.0), _MOST_SHARE)
        found = MappedBend(angle_between(first, last) / ahead, 0.0, extent_m=elbow.extent_m)
    return found.angle_rad


def apart_rad(body: BodySpec, look: RobotLook) -> float:
    """Return by how much the axes of the held parts differ; 0 if fewer than two are known."""
    axes = [axis_at(body, look.numbers, part) for part in sorted(look.held)]
    known = [axis for axis in axes if axis is not None]
    return max((angle_between(known[0], axis) for axis in known[1:]), default=0.0)
