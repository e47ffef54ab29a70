"""Where the parts of a robot are in the legs of a map, by their wheels and joints."""

from __future__ import annotations

from math import radians

from pirate_sm.core.geometry import between, dot
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import WHOLE, axis_at, axis_of
from pirate_sm.lab.mapping.leg_meetings import angle_between, outermost
from pirate_sm.lab.mapping.looks import RobotLook
from pirate_sm.lab.mapping.shape import Shape
from pirate_sm.lab.mapping.spots import Anchor, Spot
from pirate_sm.lab.mapping.way import Way

ALONG_RAD = radians(10)
"""Two parts whose axes differ by less are in one leg [decided]."""


class PartPlaces:
    """Follows the parts whose places are known.

    Args:
        robot: The robot.
        shape: What its joints show.

    Attributes:
        spots: Where parts are, by their index.
        ways_m: How far each part has travelled.
    """

    def __init__(self, robot: RobotSpec, shape: Shape) -> None:
        self.spots: dict[int, Spot] = {}
        self.ways_m = [0.0 for _ in robot.body.parts]
        self._body, self._shape, self._way = robot.body, shape, Way(robot)
        self._links: dict[int, tuple[tuple[int, ...], float]] = {}

    def move(self, look: RobotLook) -> None:
        """Move what is known by what the odometer has counted since the last look."""
        parts = [part for part in self.spots if part != WHOLE]
        bent = [part for part in parts if not self._shape.lies(look, part)]
        before_m, self.ways_m = self.ways_m, self._way.until(look, parts, self._apart(look), bent)
        moved_m = [now - then for now, then in zip(self.ways_m, before_m, strict=True)]
        for part, spot in self.spots.items():
            way_m = moved_m[part] if part != WHOLE else sum(moved_m) / len(moved_m)
            self.spots[part] = spot._replace(along_m=spot.along_m + way_m)

    def shift(self, leg: int, by_m: float) -> None:
        """Correct the places of parts in a leg."""
        for part, spot in self.spots.items():
            if spot.leg == leg:
                self.spots[part] = spot._replace(along_m=spot.along_m + by_m)

    def laid(self, look: RobotLook, part: int, spot: Spot) -> Spot:
        """Return the place of the whole robot from that of a part."""
        frame, whole = self._shape.frame(look, part, spot), self._shape.whole(look)
        away_m = 0.0
        if frame is not None and whole is not None:
            away_m = dot(between(frame.origin, whole.origin), frame.ahead)
        return Spot(spot.leg, spot.along_m + away_m, self._body.wheels_of(WHOLE))

    def anchor(self, look: RobotLook) -> Anchor | None:
        """Return a part that lies along its leg, or whose outermost link does; None without one."""
        for part, spot in self.spots.items():
            if part == WHOLE or not self._shape.lies(look, part):
                continue
            frame = axis_at(self._body, look.numbers, part)
            if frame is None:
                continue
            own = self._body.wheels_of(part)
            if spot.wheels != own:  # from now on the whole V counts
                link = self._shape.frame(look, part, spot)
                away_m = dot(between(link.origin, frame.origin), frame.ahead) if link else 0.0
                self.spots[part] = Spot(spot.leg, spot.along_m + away_m, own)
            wheels = outermost(self._body, part, 1 if own[0] == 0 else -1)
            link = axis_of(self._body, look.numbers, wheels, self._shape.bore(part))
            if link is not None:
                away_m = dot(between(frame.origin, link.origin), frame.ahead)
                self._links[part] = wheels, away_m
            return Anchor(part, frame, self.spots[part].along_m, whole=True)
        return self._pulled(look)

    def _pulled(self, look: RobotLook) -> Anchor | None:
        """Return a part that another one has pulled out of shape, by its outermost link."""
        for part, spot in self.spots.items():
            if part in self._links and spot.wheels == self._body.wheels_of(part):
                wheels, away_m = self._links[part]
                frame = axis_of(self._body, look.numbers, wheels, self._shape.bore(part))
                if frame is not None:
                    return Anchor(part, frame, spot.along_m + away_m, whole=False)
        return None

    def _apart(self, look: RobotLook) -> dict[int, float]:
        """Return where parts along one leg are against each other, m."""
        axes = {
            part: axis
            for part in self.spots
            if part != WHOLE and (axis := axis_at(self._body, look.numbers, part)) is not None
        }
        if len(axes) < 2 or len({self.spots[part].leg for part in axes}) > 1:
            return {}
        one, *others = axes.values()
        if any(angle_between(one, other) > ALONG_RAD for other in others):
            return {}
        return {part: dot(between(one.origin, it.origin), one.ahead) for part, it in axes.items()}
