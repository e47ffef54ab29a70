"""Positions of the wheels from what a camera has seen of the robot.

A tag gives the middle and the heading of its link, and so both wheels of the link. A link whose
tag is not seen for a moment is laid onto its neighbours by the joint angles. A marker gives one
point of the robot; dead reckoning gives the shape and the heading of the chain.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, inf, isnan, nan, sin
from typing import NamedTuple, Protocol

from pirate_sm.core.events import Sighting
from pirate_sm.core.geometry import Place, Pose, Route, inner_corner
from pirate_sm.core.sensing import BodySpec
from pirate_sm.robot.detectors.dead_reckoning import Reckoned

BRIDGED_S = 0.3
"""How long joint angles stand in for a tag that is not seen [decided]: it drives 30 mm in it."""

_UNKNOWN: Place = (nan, nan)


class SeenWheels(NamedTuple):
    """Where the wheels were at the time of a sighting; NaN is unknown.

    Attributes:
        places_m: Position of each wheel along the pipe; NaN also for one outside of it.
        points: The same positions in the plane of the pipe.
    """

    places_m: tuple[float, ...]
    points: tuple[Place, ...]

    @property
    def outside(self) -> bool:
        """Return whether a wheel was seen outside of the pipe, where none can be."""
        pairs = zip(self.places_m, self.points, strict=True)
        return any(isnan(place) and not isnan(x) for place, (x, _) in pairs)


class Placing(Protocol):
    """A way to find the wheels from what was seen."""

    def place(self, sighting: Sighting, angles: Sequence[float]) -> SeenWheels:
        """Return where the wheels were; ``angles`` has the angle at each wheel, rad."""


class Tags:
    """Finds the wheels from tags on the links.

    Args:
        body: The robot's chain.
        route: The route through the pipe.
        links: Index of the link of each module with a tag.
    """

    def __init__(self, body: BodySpec, route: Route, links: Mapping[str, int]) -> None:
        self._body = body
        self._route = route
        self._links = links
        self._origin = inner_corner(route)
        self._seen_s = [-inf] * len(body.lengths_m)

    def place(self, sighting: Sighting, angles: Sequence[float]) -> SeenWheels:
        """Return where the wheels were."""
        chains = []
        for mark in sighting.marks:
            if mark.heading_rad is not None:
                link = self._links[mark.on]
                self._seen_s[link] = sighting.captured_s
                chains.append((link, self._laid(mark.place_m, mark.heading_rad, link, angles)))
        if not chains:
            return _nowhere(len(angles))
        points = [self._wheel(wheel, chains, sighting.captured_s) for wheel in range(len(angles))]
        return _along(self._route, points)

    def _laid(
        self, place_m: Place, heading_rad: float, link: int, angles: Sequence[float]
    ) -> Sequence[Place]:
        """Return all wheels, in the plane of the pipe, by the tag of one link and the joints."""
        half_m = self._body.lengths_m[link] / 2
        x = place_m[0] + self._origin[0] + half_m * cos(heading_rad)
        y = place_m[1] + self._origin[1] + half_m * sin(heading_rad)
        return self._body.places(angles, link, Pose(x, y, heading_rad))

    def _wheel(
        self, wheel: int, chains: Sequence[tuple[int, Sequence[Place]]], captured_s: float
    ) -> Place:
        """Return the mean of what the tags of its links show, else what the nearest tag shows."""
        shown = [places[wheel] for link, places in chains if wheel in (link, link + 1)]
        if shown:
            return (sum(x for x, _ in shown) / len(shown), sum(y for _, y in shown) / len(shown))
        link, places = min(chains, key=lambda each: abs(each[0] + 0.5 - wheel))
        oldest_s = min(self._seen_s[min(wheel, link) : max(wheel, link)])
        return places[wheel] if captured_s - oldest_s <= BRIDGED_S else _UNKNOWN


class OneMarker:
    """Finds the wheels from one marker, with the shape of the chain by dead reckoning.

    Args:
        route: The route through the pipe.
        link: Index of the link in whose middle the marker is.
    """

    def __init__(self, route: Route, link: int) -> None:
        self._route = route
        self._link = link
        self._origin = inner_corner(route)
        self.reckoned: Reckoned | None = None

    def place(self, sighting: Sighting, angles: Sequence[float]) -> SeenWheels:
        """Return where the wheels were, with the shape in ``reckoned``."""
        if self.reckoned is None or not sighting.marks:
            return _nowhere(len(angles))
        points, mark = self.reckoned.points, sighting.marks[0]
        (ax, ay), (bx, by) = points[self._link], points[self._link + 1]
        dx = mark.place_m[0] + self._origin[0] - (ax + bx) / 2
        dy = mark.place_m[1] + self._origin[1] - (ay + by) / 2
        return _along(self._route, [(x + dx, y + dy) for x, y in points])


def _nowhere(wheels: int) -> SeenWheels:
    return SeenWheels((nan,) * wheels, (_UNKNOWN,) * wheels)


def _along(route: Route, points: Sequence[Place]) -> SeenWheels:
    return SeenWheels(tuple(_arc(route, point) for point in points), tuple(points))


def _arc(route: Route, point: Place) -> float:
    """Return where a point is along the pipe; NaN if it is unknown or outside of the pipe.

    In the outer corner of a square mitre the wall is 0.71 of the diameter from the centre line, so
    a whole diameter allows for errors, and for no other pipe [decided].
    """
    arc_m, away_m = route.nearest((*point, 0.0))
    return arc_m if away_m < route.piece_at(arc_m).diameter_m else nan
