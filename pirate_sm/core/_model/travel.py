"""How a robot travels along a route: which mission passes which joint of a pipe."""

from __future__ import annotations

from math import asin, pi, radians, remainder
from typing import Annotated, Literal

from pydantic import Field

from pirate_sm.core._geometry.route import JointKind
from pirate_sm.core._geometry.space import Frame, Vector, dot
from pirate_sm.core._model.base import Frozen
from pirate_sm.core._model.quantities import Angle

_OFF_RAD = radians(15)
"""How far an opening may be off the direction of a passage: rolled by 15 deg against a mitre, an
elbow or a branch, a robot passes it 6 times of 6, by 20 deg 3 to 6 times, by 30 deg 0 to 3 times
[measured in 3-D, 120 mm, flat]."""

_LYING_RAD = radians(45)
"""How far a robot may be off the roll of a turn: half way to the next one [decided]."""


class Turn(Frozen):
    """A mission that turns the robot about the pipe's axis, where it stands.

    Attributes:
        call: The mission.
        rolls: By how much it turns the robot, side A up where the pipe is flat.
        lying: Rolls against the horizontal from which it turns: 90 deg has side A up in normal
            polarity. Absent: any.
        upright: Which way an upright leg leads in which it turns; absent: in none.
    """

    call: str
    rolls: Angle
    lying: tuple[Angle, ...] = ()
    upright: Literal["up", "down"] | None = None

    def turns_from(self, rolled_rad: float) -> bool:
        """Return whether it turns a robot that is rolled so against the horizontal."""
        off = (abs(remainder(rolled_rad - each, 2 * pi)) for each in self.lying)
        return not self.lying or any(angle <= _LYING_RAD + 1e-9 for angle in off)


class PassedBy(Frozen):
    """A kind of joint, and the missions that pass it.

    Attributes:
        joints: The kinds of joints.
        turns: Whether the route turns there, or leads straight on; absent: either.
        up_to: The sharpest turn of the route that these pass. Absent: any.
        towards: Directions of the turn or of the opening about the direction of travel, against the
            robot's plane: 0 deg is towards side A in normal polarity. Absent: any.
        calls: The missions that pass it, one after the other; none: the robot drives on.
    """

    joints: Annotated[tuple[JointKind, ...], Field(min_length=1)]
    turns: bool | None = None
    up_to: Angle | None = None
    towards: tuple[Angle, ...] = ()
    calls: tuple[str, ...] = ()

    def suits(self, kind: JointKind, turn_rad: float) -> bool:
        """Return whether this is for a joint of a kind at which the route turns by an angle."""
        asked = self.turns in (None, bool(turn_rad))
        sharp = self.up_to is not None and abs(turn_rad) > self.up_to + 1e-9
        return kind in self.joints and asked and not sharp

    def passes(self, kind: JointKind, turn_rad: float, towards_rad: float) -> bool:
        """Return whether this passes a joint of a kind that turns towards a direction."""
        if not self.suits(kind, turn_rad):
            return False
        off = (abs(remainder(towards_rad - each, 2 * pi)) for each in self.towards)
        return not self.towards or any(angle <= _OFF_RAD for angle in off)


class Travel(Frozen):
    """The missions that a mission along a route is made of; each begins and ends in one state.

    Attributes:
        starts_in: This state of the robot.
        last: The mission that drives on to the end of the route; its parameter `way` says how far.
        passages: What passes the joints; the first that fits is taken.
        turns: What turns the robot before a joint that no passage fits.
        upright: From which slope on a leg is upright for these.
    """

    starts_in: dict[str, str] = {}
    last: str
    turns: tuple[Turn, ...] = ()
    upright: Annotated[Angle, Field(gt=0)] = radians(77)
    passages: tuple[PassedBy, ...] = ()

    def is_upright(self, frame: Frame, up: Vector) -> bool:
        """Return whether a leg with this frame is upright for these missions."""
        return abs(_climbs_rad(frame, up)) >= self.upright

    def turns_at(self, turn: Turn, frame: Frame, up: Vector, roll_rad: float) -> bool:
        """Return whether a mission turns a robot of this roll in a leg with this frame."""
        if self.is_upright(frame, up):
            return turn.upright == ("up" if _climbs_rad(frame, up) > 0 else "down")
        return turn.turns_from(roll_rad - (frame.roll_of(up) - pi / 2))


def _climbs_rad(frame: Frame, up: Vector) -> float:
    """Return how steep a leg climbs."""
    return asin(min(max(dot(frame.ahead, up), -1.0), 1.0))
