"""Dead reckoning: the position of each wheel in the pipe, from joints, wheels and known walls.

A part whose clamp is confirmed is an anchor: the mean position of its wheels moves only by what the
odometer counts. It lies in its leg, with each wheel at the wall that it touches when clamped, at a
roll about the leg that stays as long as it holds. The measured angles of the bend joints and of the
roll joint give the rest of the chain in space. Without a confirmed clamp all wheels are the anchor,
on the centre line.

The position of a wheel depends on the joints inside the anchor and on those between the anchor and
the wheel. If one of them is unknown, so is the position, unless another clamped part gives it. A
part that clamps gets its place and its roll from the chain. If the place is unknown at this moment,
the robot's position is lost, and no later measurement can recover it. While the roll is unknown, as
in a round pipe after the robot has let go, only wheels in the anchor's straight have positions.

Two measurements correct this. An anchor is moved to the nearest place at which no wheel of the
chain is in a wall: round a bend, in an elbow or at a tee the shape of the chain fits the pipe at
one place. And an anchor has the roll that the inertial unit shows, where its leg is not steep.

Neglected, where neither of them shows it: slip; motion of a part while it clamps, relaxes or is
pushed; rolling of an anchor in its leg, and of a robot that begins loose until it clamps; that
wheels on the outer side of an elbow roll farther; the odometer's lag of one round of the boards. An
anchor that stands in two legs at once is assumed to lie in that of its middle; it shows another
diameter then, and is not moved. Between bars every part is assumed to lie in their plane.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import atan2, cos, hypot, inf, isfinite, isnan, nan, pi, radians, remainder, sin
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core.geometry import (
    DRAWING,
    ChainInSpace,
    Place,
    Route,
    Vector,
    dot,
    flat,
    in_space,
)
from pirate_sm.core.sensing import WHOLE, BodySpec
from pirate_sm.robot.detectors.room import Room

# --- walls ----------------------------------------------------------------------------------------


_IN_WALL_M = 0.005
"""A wheel that is deeper in a wall shows that the robot is elsewhere. At its true place it is less
than 4 mm in 9 of 10 looks [measured in 3-D]: diameters are uncertain, and a part leans."""

_CLEAR_M = 0.003
"""Where no wheel is deeper in a wall than this, the robot may be [decided]."""

_STEP_M = 0.003

_MOST_M = 0.25
"""Places farther away are never looked at: what happened on so long a way is unknown [decided]."""


class KnownWalls:
    """The walls of the pipes of a route.

    Args:
        route: The route.
        wheel_radius_m: Radius of the robot's wheels.
        reach_m: How far a wheel may be from any other one.
    """

    def __init__(self, route: Route, wheel_radius_m: float, reach_m: float) -> None:
        self._everywhere = Room.of(route, wheel_radius_m)
        self._reach_m = reach_m + _MOST_M

    def away_m(
        self, points: Sequence[Vector], laid: Callable[[float], Sequence[Vector]], most_m: float
    ) -> float:
        """Return how far away the nearest place is at which no wheel is in a wall.

        Args:
            points: The wheels of the robot, one of them at least known; NaN is unknown.
            laid: Returns them after the robot was moved ahead by a distance.
            most_m: Places farther away are not looked at.

        Returns:
            The distance, positive ahead; 0 if the robot may be where it is; NaN if there is no
            such place.
        """
        known = [point for point in points if not isnan(point[0])]
        if _have_room(self._everywhere, known, _IN_WALL_M):
            return 0.0
        near = self._everywhere.near(known[0], self._reach_m)
        for step in range(1, round(min(most_m, _MOST_M) / _STEP_M) + 1):
            for away_m in (step * _STEP_M, -step * _STEP_M):
                if _have_room(near, laid(away_m), _CLEAR_M):
                    return away_m
        return nan


def _have_room(room: Room, points: Sequence[Vector], most_m: float) -> bool:
    """Return whether no wheel is farther in a wall; an unknown one is in none."""
    return all(isnan(it[0]) or room.outside_m(it, most_m) <= most_m for it in points)


# --- reckoning ------------------------------------------------------------------------------------


_AGREEING = 0.03
"""A V that shows the diameter of its leg up to this share lies along it [decided]."""

_FLAT_RAD = radians(10)
"""Parts whose planes differ by more are not held to the walls: the one that holds is turned out of
its leg by the weight of the other [measured: by up to 10 deg]."""

_ONE_AXIS_RAD = radians(5)
"""Axes of two parts in one leg differ by up to 3 deg [measured]."""

_PUSHED_M = 0.03
"""An anchor is not moved by more, and what was rolled since the walls were last looked at. A
braked part is pushed by up to 25 mm [measured in 3-D]."""

_LEVEL = 0.7
"""With a smaller share of gravity across the leg (45 deg) the roll is not taken from gravity."""

_UNKNOWN: Vector = (nan, nan, nan)

_RIGID = -1
"""Instead of the link with a roll joint: none."""


Shape: TypeAlias = Literal["fits", "contradicts", "unknown"]


class AnchorSpot(NamedTuple):
    """Place of an anchor.

    Attributes:
        middle_m: The middle of its wheels along the pipe.
        roll_rad: Roll of its plane against the frame of the pipe there; NaN is unknown.
    """

    middle_m: float
    roll_rad: float


class Felt(NamedTuple):
    """Roll of a clamped part against the horizontal, as the inertial unit shows it."""

    part: int
    roll_rad: float


class Reckoned(NamedTuple):
    """The estimated position of the robot; NaN is unknown.

    Attributes:
        places_m: Position of each wheel along the pipe.
        chain: The robot in the pipe; of unknown roll, it is drawn in the plane of roll 0.
        odometer_m: Reading of the odometer.
        anchor: Index of the part from which positions are reckoned first, or ``WHOLE``.
        spots: Place of each anchor, by part; a lost one is missing.
        checked_m: Reading of the odometer when the walls were last compared with the chain.
        shape: Whether the robot, as its joints show it, has room in the pipe there with each anchor
            along its leg. It is unknown without an anchor, and while the roll joint is turned.
        straight: Whether each anchor lies along its leg, and all along one axis.
    """

    places_m: tuple[float, ...]
    chain: ChainInSpace
    odometer_m: float
    anchor: int
    spots: dict[int, AnchorSpot]
    checked_m: float
    shape: Shape = "unknown"
    straight: bool = False

    @property
    def points(self) -> tuple[Place, ...]:
        """Return the position of each wheel in the plane of the drawing."""
        return tuple(flat(point) for point in self.chain.points)

    @property
    def lost(self) -> bool:
        """Whether the place of every anchor is lost."""
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
        self._flat = route.section == "bars"
        self._rolls = not self._flat and body.roll >= 0
        self._posed = lru_cache(self._pose)  # places are tried with one pose
        self._walls = KnownWalls(route, body.wheel_radius_m, sum(body.lengths_m))

    def unknown(self, numbers: Sequence[float]) -> list[int]:
        """Return the indexes of the joints that are unknown."""
        roll = [self._body.roll] if self._rolls else []
        return [each for each in (*self._body.joints, *roll) if each >= 0 and isnan(numbers[each])]

    def begin(
        self,
        first_wheel_m: float,
        numbers: Sequence[float],
        held: frozenset[int] = frozenset(),
        roll_rad: float = 0.0,
    ) -> Reckoned:
        """Return the position of a robot whose first wheel began at a known position.

        Args:
            first_wheel_m: Position of the first wheel along the pipe when the odometer stood at
                zero. The whole robot is in the same leg.
            numbers: The engine's signals in SI; those of the joints must be known.
            held: Parts whose clamp is confirmed.
            roll_rad: Roll of the robot against the frame of the pipe there.
        """
        counted = self._counted(numbers, 0.0)
        anchor = min(held, default=WHOLE)
        spot = AnchorSpot(first_wheel_m + counted, 0.0 if self._flat else roll_rad)
        chain = self._lay(numbers, anchor, spot, (0,))
        places = self._places(chain, spot)
        stood = {each: self._stand(each, chain, places) for each in held or {WHOLE}}
        spots = {each: spot for each, spot in stood.items() if spot is not None}
        straight = self.straight(numbers, spots)
        return Reckoned(places, chain, counted, anchor, spots, counted, straight=straight)

    def look(
        self,
        before: Reckoned,
        numbers: Sequence[float],
        held: frozenset[int],
        felt: Felt | None = None,
    ) -> Reckoned:
        """Return the present positions.

        Args:
            before: The positions at the last look.
            numbers: As for :meth:`begin`; NaN is unknown.
            held: As for :meth:`begin`.
            felt: The roll that the inertial unit shows, if any.
        """
        counted = self._counted(numbers, before.odometer_m)
        moved_m = counted - before.odometer_m
        anchors = held or frozenset({WHOLE})
        spots = self._carried(before, numbers, anchors, moved_m)
        if not spots:
            return self._nowhere(counted, min(held, default=WHOLE))
        if felt is not None and felt.part in spots:
            spots[felt.part] = self._levelled(spots[felt.part], felt.roll_rad)
        anchor = self._first_of(before.anchor, spots, numbers)
        chain = self._lay(numbers, anchor, spots[anchor])
        most_m = _PUSHED_M + abs(counted - before.checked_m)
        away_m, shape = self._away_m(numbers, anchor, spots[anchor], chain, most_m)
        if away_m and isfinite(away_m):
            spots[anchor] = _moved(spots[anchor], away_m)
            chain = self._lay(numbers, anchor, spots[anchor])
        places = self._places(chain, spots[anchor])
        for other in spots.keys() - {anchor}:
            # The first anchor's estimate of another one holds; only the odometer replaces it.
            spots[other] = self._stand(other, chain, places) or spots[other]
        if any(map(isnan, places)):
            for other in sorted(spots):
                chain = _filled(chain, self._lay(numbers, other, spots[other]))
            places = self._places(chain, spots[anchor])
        checked_m = before.checked_m if isnan(away_m) else counted
        straight = self.straight(numbers, spots)
        if shape == "fits" and not straight:
            shape = "contradicts"
        return Reckoned(places, chain, counted, anchor, spots, checked_m, shape, straight)

    def roll_of(self, reckoned: Reckoned, part: int) -> float:
        """Return the roll of a part against the frame of the pipe there, rad; NaN is unknown."""
        spot = reckoned.spots.get(part)
        spot = spot or self._stand(part, reckoned.chain, reckoned.places_m)
        return nan if spot is None else spot.roll_rad

    # --- anchors ------------------------------------------------------------------------------

    def _shaped(self, before: Reckoned, numbers: Sequence[float]) -> Reckoned:
        """Return the positions of before with the joints as they are now, where these are known."""
        spot = before.spots.get(before.anchor)
        if spot is None:
            return before
        chain = _filled(self._lay(numbers, before.anchor, spot), before.chain)
        return before._replace(chain=chain, places_m=self._places(chain, spot))

    def _carried(
        self, before: Reckoned, numbers: Sequence[float], anchors: frozenset[int], moved_m: float
    ) -> dict[int, AnchorSpot]:
        """Return the places of those anchors that are known, moved by the odometer."""
        spots: dict[int, AnchorSpot] = {}
        known = not all(isnan(spot.roll_rad) for spot in before.spots.values())
        for anchor in anchors:
            spot = before.spots.get(anchor)
            if spot is None:  # a part has clamped since, and its joints have moved
                shaped = self._shaped(before, numbers)
                spot = self._stand(anchor, shaped.chain, shaped.places_m)
                if spot is not None and not self._flat and (anchor == WHOLE or not known):
                    spot = spot._replace(roll_rad=nan)
            if spot is not None:
                spots[anchor] = _moved(spot, moved_m)
        return spots

    def _first_of(self, before: int, spots: dict[int, AnchorSpot], numbers: Sequence[float]) -> int:
        """Return the anchor that gives the places: that of before, unless another one is surer."""

        def sure(anchor: int) -> tuple[bool, bool, bool]:
            spot = spots[anchor]
            lies = self.lies(numbers, anchor, spot.middle_m)
            return not isnan(spot.roll_rad), lies, anchor == before

        return max(sorted(spots), key=sure)

    def lies(self, numbers: Sequence[float], part: int, middle_m: float) -> bool:
        """Return whether the V of a part shows the diameter of its leg."""
        shown, bore_m = self._body.parts[part].diameter, self._route.diameter_at(middle_m)
        return shown >= 0 and abs(numbers[shown] - bore_m) <= _AGREEING * bore_m

    def straight(self, numbers: Sequence[float], spots: dict[int, AnchorSpot]) -> bool:
        """Return whether each anchor lies along its leg, and all along one axis."""
        if not all(self.lies(numbers, at, spot.middle_m) for at, spot in spots.items()):
            return False
        headings = [self._body.heading_in_pipe(numbers, part, 0) for part in spots]
        return max(headings) - min(headings) <= _ONE_AXIS_RAD

    def _levelled(self, spot: AnchorSpot, felt_rad: float) -> AnchorSpot:
        """Return a place with the roll that is felt against the horizontal."""
        frame, up = self._route.frame_at(spot.middle_m), self._route.up
        aside, above = dot(frame.side, up), -dot(frame.normal, up)
        if self._flat or isnan(felt_rad) or hypot(aside, above) < _LEVEL:
            return spot
        return spot._replace(roll_rad=remainder(felt_rad - atan2(aside, above), 2 * pi))

    def _away_m(
        self,
        numbers: Sequence[float],
        anchor: int,
        spot: AnchorSpot,
        chain: ChainInSpace,
        most_m: float,
    ) -> tuple[float, Shape]:
        """Return how far away an anchor is by the walls, m, and what they say of the shape.

        The distance is NaN if the walls do not show it, and infinite if they leave no place: then
        a joint is wrong, and what is rolled from now on explains no place farther away.
        """
        level = abs(self._turned_rad(numbers)) <= _FLAT_RAD
        if anchor == WHOLE or not level or isnan(spot.roll_rad):
            return nan, "unknown"
        if not self.lies(numbers, anchor, spot.middle_m):
            return nan, "contradicts"

        def laid(away_m: float) -> Sequence[Vector]:
            return self._lay(numbers, anchor, _moved(spot, away_m)).points

        if all(isnan(sum(point)) for point in chain.points):
            return nan, "unknown"
        away_m = self._walls.away_m(chain.points, laid, most_m)
        return (inf, "contradicts") if isnan(away_m) else (away_m, "fits")

    def _stand(
        self, anchor: int, chain: ChainInSpace, places_m: Sequence[float]
    ) -> AnchorSpot | None:
        """Return an anchor's place from those of its wheels; None if one is unknown."""
        wheels = self._body.wheels_of(anchor)
        if any(isnan(places_m[wheel]) for wheel in wheels):
            return None
        piece = self._route.piece_at(_mean([places_m[wheel] for wheel in wheels]))
        # Not the mean of the positions: they jump where a wheel cuts the corner of a mitre.
        beyond = [piece.beyond_m(chain.points[wheel]) for wheel in wheels]
        middle_m = piece.arc_m + _mean(beyond)
        normal = (chain.front if wheels[0] <= self._body.roll_link else chain.rear).normal
        frame = self._route.frame_at(middle_m)
        return AnchorSpot(middle_m, atan2(dot(normal, frame.side), dot(normal, frame.normal)))

    def _counted(self, numbers: Sequence[float], before: float) -> float:
        counted = numbers[self._odometer] if self._odometer >= 0 else before
        return before if isnan(counted) else counted

    # --- the chain ----------------------------------------------------------------------------

    def _lay(
        self, numbers: Sequence[float], anchor: int, spot: AnchorSpot, at: tuple[int, ...] = ()
    ) -> ChainInSpace:
        """Return the chain laid into the pipe, with the middle of the wheels ``at`` at the spot.

        Args:
            numbers: The engine's signals in SI.
            anchor: The part that lies along the pipe.
            spot: Its place.
            at: The wheels at the spot; by default the anchor's.
        """
        body, aside_m = self._body, 0.0 if anchor == WHOLE else self._aside_m(spot.middle_m)
        roll_rad = 0.0 if isnan(spot.roll_rad) else spot.roll_rad
        return in_space(
            self._posed(body.angles(numbers), anchor, aside_m, at),
            self._route.frame_at(spot.middle_m).rolled(roll_rad),
            wheel=body.wheels_of(anchor)[0],
            link=body.roll_link if self._rolls else _RIGID,
            roll_rad=self._turned_rad(numbers),
        )

    def _pose(
        self, angles: tuple[float, ...], anchor: int, aside_m: float, at: tuple[int, ...]
    ) -> Sequence[Place]:
        """Return the wheels in the plane of an anchor that lies along x; see :meth:`_lay`."""
        body, wheels = self._body, self._body.wheels_of(anchor)
        shape = body.places(angles, wheels[0])
        turn = body.lean(shape, wheels, aside_m)
        c, s = cos(turn), sin(turn)
        laid = [(x * c - y * s, x * s + y * c) for x, y in shape]
        forward = -_mean([x for x, _ in (laid[wheel] for wheel in at or wheels)])
        across = _mean([body.sides[wheel] * aside_m - laid[wheel][1] for wheel in wheels])
        return [(x + forward, y + across) for x, y in laid]

    def _turned_rad(self, numbers: Sequence[float]) -> float:
        """Return the angle of the roll joint; 0 without one."""
        return numbers[self._body.roll] if self._rolls else 0.0

    def _aside_m(self, arc_m: float) -> float:
        """Return how far from the axis a wheel is that touches the wall."""
        return self._route.diameter_at(arc_m) / 2 - self._body.wheel_radius_m

    def _places(self, chain: ChainInSpace, spot: AnchorSpot) -> tuple[float, ...]:
        """Return the position of each wheel along the pipe; NaN where it is unknown."""
        places = (nan if isnan(sum(it)) else self._route.arc_of(it) for it in chain.points)
        if not isnan(spot.roll_rad):
            return tuple(places)
        return tuple(nan if self._turns(spot.middle_m, place) else place for place in places)

    def _turns(self, one_m: float, other_m: float) -> bool:
        """Return whether the route turns between two places."""
        least_m, most_m = sorted((one_m, other_m))
        return any(
            joint.turn_rad
            and joint.arc_m - joint.before_m < most_m
            and joint.arc_m + joint.behind_m > least_m
            for joint in self._route.joints
        )

    def _nowhere(self, counted_m: float, anchor: int) -> Reckoned:
        count = len(self._body.joints)
        chain = ChainInSpace((_UNKNOWN,) * count, DRAWING, DRAWING)
        return Reckoned((nan,) * count, chain, counted_m, anchor, {}, counted_m)


def _moved(spot: AnchorSpot, by_m: float) -> AnchorSpot:
    return spot._replace(middle_m=spot.middle_m + by_m)


def _filled(chain: ChainInSpace, other: ChainInSpace) -> ChainInSpace:
    """Return a chain with another one's places where its own are unknown."""
    points = tuple(
        second if isnan(sum(first)) else first
        for first, second in zip(chain.points, other.points, strict=True)
    )
    front = other.front if isnan(sum(chain.front.normal)) else chain.front
    rear = other.rear if isnan(sum(chain.rear.normal)) else chain.rear
    return chain._replace(points=points, front=front, rear=rear)


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
