"""Correct dead reckoning where the joint angles show a bend whose place is known.

Two moments are used, see :mod:`pirate_sm.detectors.leg_meetings`: when the first part clamps
behind the bend, and when the last part clamps. In between the first part is pushed by a centimetre
or two, which no odometer sees. What is shown counts only if it fits the bend: the anchor lies along
its leg, the angle is that of the bend, and the correction is small. Otherwise nothing changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan, radians

from pirate_sm.detectors.dead_reckoning import Reckoned, Spot
from pirate_sm.detectors.leg_meetings import Reached, away_by_last_wheel, reached
from pirate_sm.engine.sensing.body_spec import BodySpec
from pirate_sm.engine.sensing.part_axes import axis_at
from pirate_sm.geometry.joints import Joint
from pirate_sm.geometry.route import Route

_AGREEING = 0.03
"""A V that shows the diameter of its leg up to this share lies along it [decided]."""

_ANGLE_RAD = radians(6)
"""A bend that is seen differs from the known one by less [decided]."""

_MOST_M = 0.06
"""No place is corrected by more: half a link [decided]."""

_FLAT_RAD = radians(10)
"""The parts lie in the plane of the pipe if the roll joint is turned by less."""


class KnownBends:
    """Corrects a reckoning at the bends of a route in a plane.

    Args:
        body: The robot's chain.
        route: The route.
    """

    def __init__(self, body: BodySpec, route: Route) -> None:
        self._body = body
        self._route = route
        self._turns = [joint for joint in route.joints if joint.turn_rad]
        self._first = -1
        self._bend: Joint | None = None

    def corrected(
        self, before: Reckoned, after: Reckoned, numbers: Sequence[float]
    ) -> Reckoned | None:
        """Return the reckoning with a corrected anchor; None if there is nothing to correct.

        Args:
            before: The reckoning of the last look.
            after: That of this look.
            numbers: The engine's signals in SI; NaN is unknown.
        """
        new = after.spots.keys() - before.spots.keys()
        kept = after.spots.keys() & before.spots.keys()
        if len(new) != 1 or len(kept) != 1 or min(kept) < 0 or not self._is_flat(numbers):
            return None
        (part,), (anchor,) = new, kept
        spot = after.spots[anchor]
        if not self._lies(numbers, anchor, spot.piece.diameter_m):
            return None
        if self._bend is not None and anchor == self._first:
            at_m = self._by_last(numbers, anchor, part, self._bend)
            self._bend = None
        else:
            at_m = self._by_first(numbers, anchor, part, spot)
        if isnan(at_m) or abs(at_m - spot.middle_m) > _MOST_M:
            return None
        moved = Spot(at_m, self._route.piece_at(at_m))
        return after._replace(spots={**after.spots, anchor: moved}, anchor=anchor)

    def _by_first(self, numbers: Sequence[float], anchor: int, part: int, spot: Spot) -> float:
        """Return the anchor's place when a part clamps first behind a bend; NaN if unknown."""
        leads = self._leads(part, anchor)
        bend = self._next(spot.middle_m, leads)
        axis = axis_at(self._body, numbers, anchor)
        if bend is None or axis is None:
            return nan
        behind_m = self._route.diameter_at(bend.arc_m + leads * (bend.behind_m + bend.before_m))
        found = reached(self._body, numbers, axis, part, leads, behind_m)
        if found is None or abs(found.angle_rad - bend.turn_rad) > _ANGLE_RAD:
            return nan
        self._first, self._bend = part, bend
        return bend.arc_m - leads * found.away_m

    def _by_last(self, numbers: Sequence[float], anchor: int, part: int, bend: Joint) -> float:
        """Return the anchor's place when the last part clamps behind it; NaN if unknown."""
        leads = self._leads(anchor, part)
        axis = axis_at(self._body, numbers, anchor)
        if axis is None:
            return nan
        known = Reached(bend.turn_rad, bend.towards_rad, 0.0, 0.0)
        bore_m = self._route.diameter_at(bend.arc_m - leads * (bend.behind_m + bend.before_m))
        away_m = away_by_last_wheel(self._body, numbers, axis, part, known, leads, bore_m)
        return bend.arc_m + leads * away_m

    def _next(self, from_m: float, leads: int) -> Joint | None:
        """Return the next bend in the direction of the part that goes first."""
        ahead = [each for each in self._turns if leads * (each.arc_m - from_m) > 0]
        return min(ahead, key=lambda each: abs(each.arc_m - from_m), default=None)

    def _leads(self, first: int, last: int) -> int:
        return 1 if self._body.wheels_of(first) < self._body.wheels_of(last) else -1

    def _lies(self, numbers: Sequence[float], part: int, bore_m: float) -> bool:
        index = self._body.parts[part].diameter
        return index >= 0 and abs(numbers[index] - bore_m) <= _AGREEING * bore_m

    def _is_flat(self, numbers: Sequence[float]) -> bool:
        return self._body.roll < 0 or abs(numbers[self._body.roll]) < _FLAT_RAD
