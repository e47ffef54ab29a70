"""The centre line of a pipe in its plane: x along the first leg, y towards side A."""

from __future__ import annotations

from itertools import pairwise
from math import cos, hypot, inf, sin
from typing import NamedTuple

from pirate_sm.model.pipe import Mitre, Pipe

Place = tuple[float, float]


class Leg(NamedTuple):
    """A straight part of the centre line.

    Attributes:
        start: Where it begins, m.
        along: Unit vector.
        length_m: Its length.
        arc_m: How far along the pipe it begins.
    """

    start: Place
    along: tuple[float, float]
    length_m: float
    arc_m: float

    def point(self, arc_m: float, aside_m: float) -> Place:
        """The point at a place along the pipe, so far towards side A of the centre line."""
        (x, y), (tx, ty), beyond = self.start, self.along, arc_m - self.arc_m
        return x + beyond * tx - aside_m * ty, y + beyond * ty + aside_m * tx

    def beyond(self, point: Place) -> float:
        """How far a point is beyond the leg's beginning, along the leg."""
        (x, y), (tx, ty) = self.start, self.along
        return (point[0] - x) * tx + (point[1] - y) * ty


class Route:
    """The legs of a pipe in order; ``crossings_m`` are the places where two of them meet."""

    def __init__(self, pipe: Pipe) -> None:
        legs: list[Leg] = []
        start, arc, heading, length = (0.0, 0.0), 0.0, 0.0, 0.0
        for segment in (*pipe.segments, None):
            if segment is not None and not isinstance(segment, Mitre):
                length += segment.straight
                continue
            legs.append(Leg(start, (cos(heading), sin(heading)), length, arc))
            arc, length = arc + length, 0.0
            start = legs[-1].point(arc, 0.0)
            if segment is not None:
                heading += segment.mitre
        self.legs = tuple(legs)
        self.crossings_m = tuple(leg.arc_m for leg in legs[1:])

    def walls(self, aside_m: float) -> tuple[tuple[Place, ...], tuple[Place, ...]]:
        """Corners of the walls on side A and on side B, so far from the centre line."""
        sides = []
        for side_m in (aside_m, -aside_m):
            corners = [self.legs[0].point(self.legs[0].arc_m, side_m)]
            for before, after in pairwise(self.legs):
                (ax, ay), (bx, by), (x, y) = before.along, after.along, after.start
                share = side_m / (1.0 + ax * bx + ay * by)  # where the two offset lines meet
                corners.append((x - share * (ay + by), y + share * (ax + bx)))
            last = self.legs[-1]
            sides.append((*corners, last.point(last.arc_m + last.length_m, side_m)))
        return sides[0], sides[1]

    def leg_at(self, arc_m: float) -> Leg:
        """The leg that a place lies on; the first and the last go on for ever."""
        return next((leg for leg in self.legs if arc_m <= leg.arc_m + leg.length_m), self.legs[-1])

    def place_of(self, point: Place) -> float:
        """How far along the pipe the nearest point of the centre line is."""
        nearest, found = inf, 0.0
        for number, leg in enumerate(self.legs):
            along = leg.beyond(point)
            if number > 0:
                along = max(along, 0.0)
            if number < len(self.legs) - 1:
                along = min(along, leg.length_m)
            x, y = leg.point(leg.arc_m + along, 0.0)
            away = hypot(point[0] - x, point[1] - y)
            if away < nearest:
                nearest, found = away, leg.arc_m + along
        return found
