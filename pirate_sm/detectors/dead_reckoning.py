"""Dead reckoning: the position of each wheel in the pipe, from the joints and the odometer alone.

A part whose clamp is confirmed is an anchor: the mean position of its wheels moves only by what the
odometer counts. It lies in its leg, with each wheel at the wall that it touches when clamped. The
measured angles of the bend joints give the rest of the chain, also round a mitre. Without a
confirmed clamp all wheels are the anchor, on the centre line.

The position of a wheel depends on the joints inside the anchor and on those between the anchor and
the wheel. If one of them is unknown, so is the position, unless another clamped part gives it. A
part that clamps gets its position from the chain. If that is unknown at this moment, the robot's
position is lost, and no later measurement can recover it.

Neglected: slip; motion of a part while it clamps, relaxes or is pushed; roll, so that the robot's
plane is assumed to be the pipe's; the odometer's lag of one round of the boards. An anchor that
stands in two legs at once is assumed to lie in that of its middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan
from typing import NamedTuple

from pirate_sm.engine.sensing.body_spec import WHOLE, BodySpec, known
from pirate_sm.geometry.piece import Piece
from pirate_sm.geometry.plane import flat, turned
from pirate_sm.geometry.route import Route
from pirate_sm.geometry.space import Place

_UNKNOWN: Place = (nan, nan)


class Spot(NamedTuple):
    """Position of an anchor: the middle of its wheels along the pipe, m, and the piece it is in."""

    middle_m: float
    piece: Piece


class Reckoned(NamedTuple):
    """The estimated position of the robot; NaN is unknown.

    Attributes:
        places_m: Position of each wheel along the pipe.
        points: The same positions in the plane of the pipe.
        odometer_m: Reading of the odometer.
        anchor: Index of the part from which positions are reckoned first, or ``WHOLE``.
        spots: Position of each anchor, by part; a lost one is missing.
    """

    places_m: tuple[float, ...]
    points: tuple[Place, ...]
    odometer_m: float
    anchor: int
    spots: dict[int, Spot]

    @property
    def lost(self) -> bool:
        """Whether the position of every anchor is lost."""
        return not self.spots


class Reckoner:
    """Updates a reckoning from one look to the next; it has no state itself.

    Args:
        body: The robot's chain.
        route: The route through the pipe.
        odometer: Index of the odometer among the signals.
    """

    def __init__(self, body: BodySpec, route: Route, odometer: int) -> None:
        self._body = body
        self._route = route
        self._odometer = odometer
        self._everything = tuple(range(len(body.joints)))

    def begin(
        self, first_wheel_m: float, numbers: Sequence[float], held: frozenset[int] = frozenset()
    ) -> Reckoned:
        """Return the position of a robot whose first wheel began at a known position.

        Args:
            first_wheel_m: Position of the first wheel along the pipe when the odometer stood at
                zero. The whole robot is in the same leg.
            numbers: The engine's signals in SI; those of the joints must be known.
            held: Parts whose clamp is confirmed.
        """
        counted = self._counted(numbers, 0.0)
        place = first_wheel_m + counted
        anchor, spot = min(held, default=WHOLE), Spot(place, self._route.piece_at(place))
        points = self._lay(self._body.angles(numbers), anchor, spot, (0,))
        places = self._places(points)
        anchors = held or {WHOLE}
        spots = {each: self._stand(each, points, places) for each in anchors}
        found = {each: spot for each, spot in spots.items() if spot is not None}
        return Reckoned(places, points, counted, anchor, found)

    def look(self, before: Reckoned, numbers: Sequence[float], held: frozenset[int]) -> Reckoned:
        """Return the present positions; arguments as of :meth:`begin`."""
        counted = self._counted(numbers, before.odometer_m)
        moved = counted - before.odometer_m
        spots = self._carried(before, held or frozenset({WHOLE}), moved)
        if not spots:
            nowhere = (_UNKNOWN,) * len(self._everything)
            return Reckoned((nan,) * len(nowhere), nowhere, counted, min(held, default=WHOLE), {})
        anchor = before.anchor if before.anchor in spots else min(spots)
        angles = self._body.angles(numbers)
        points = self._lay(angles, anchor, spots[anchor])
        places = self._places(points)
        for other in spots.keys() - {anchor}:
            # The first anchor's estimate of another one holds; only the odometer replaces it.
            spots[other] = self._stand(other, points, places) or spots[other]
        if not known(points, self._everything):
            for other in sorted(spots.keys() - {anchor}):
                more = self._lay(angles, other, spots[other])
                points = tuple(
                    second if isnan(first[0]) else first
                    for first, second in zip(points, more, strict=True)
                )
            places = self._places(points)
        return Reckoned(places, points, counted, anchor, spots)

    def _carried(
        self, before: Reckoned, anchors: frozenset[int], moved_m: float
    ) -> dict[int, Spot]:
        """Return the positions of those anchors that are known, moved by the odometer."""
        spots: dict[int, Spot] = {}
        for anchor in anchors:
            spot = before.spots.get(anchor)
            if spot is None:  # a new anchor: the chain gives its position
                spot = self._stand(anchor, before.points, before.places_m)
            if spot is not None:
                middle_m = spot.middle_m + moved_m
                spots[anchor] = Spot(middle_m, self._route.piece_at(middle_m))
        return spots

    def _stand(
        self, anchor: int, points: Sequence[Place], places_m: Sequence[float]
    ) -> Spot | None:
        """Return an anchor's position from those of its wheels; None if one is unknown."""
        wheels = self._body.wheels_of(anchor)
        if not known(points, wheels):
            return None
        piece = self._route.piece_at(_mean([places_m[wheel] for wheel in wheels]))
        # Not the mean of the positions: they jump where a wheel cuts the corner of a mitre.
        beyond = [piece.beyond_m((*points[wheel], 0.0)) for wheel in wheels]
        return Spot(piece.arc_m + _mean(beyond), piece)

    def _counted(self, numbers: Sequence[float], before: float) -> float:
        counted = numbers[self._odometer] if self._odometer >= 0 else before
        return before if isnan(counted) else counted

    def _lay(
        self, angles: Sequence[float], anchor: int, spot: Spot, at: tuple[int, ...] | None = None
    ) -> tuple[Place, ...]:
        """Return the chain laid into the pipe, with the middle of the wheels ``at`` at the spot.

        Args:
            angles: The angle at each wheel.
            anchor: The part that lies along the pipe.
            spot: Its position.
            at: The wheels at the spot; by default the anchor's.
        """
        wheels = self._body.wheels_of(anchor)
        wall_m = spot.piece.diameter_m / 2 - self._body.wheel_radius_m
        aside_m = 0.0 if anchor == WHOLE else wall_m
        shape = self._body.places(angles, wheels[0])
        turn = self._body.lean(shape, wheels, aside_m)
        laid = [turned(place, turn) for place in shape]
        forward = spot.middle_m - _mean([laid[wheel][0] for wheel in at or wheels])
        sides = self._body.sides
        across = _mean([sides[wheel] * aside_m - laid[wheel][1] for wheel in wheels])
        frame, arc_m = spot.piece.frame, spot.piece.arc_m
        return tuple(flat(frame.point(x + forward - arc_m, y + across)) for x, y in laid)

    def _places(self, points: Sequence[Place]) -> tuple[float, ...]:
        return tuple(nan if isnan(x) else self._route.arc_of((x, y, 0.0)) for x, y in points)


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
