"""How a robot travels along a route: which mission passes which joint of a pipe."""

from __future__ import annotations

from math import pi, radians, remainder
from typing import Annotated

from pydantic import Field

from pirate_sm.geometry.joints import JointKind
from pirate_sm.model.base import Frozen
from pirate_sm.model.quantities import Angle

_OFF_RAD = radians(20)
"""How far an opening may be off the direction of a passage [decided]."""


class PassedBy(Frozen):
    """A kind of joint, and the missions that pass it.

    Attributes:
        joints: The kinds of joints.
        turns: Whether the route turns there, or leads straight on; absent: either.
        towards: Directions of the turn or of the opening about the direction of travel, against the
            robot's plane: 0 deg is towards side A in normal polarity. Absent: any.
        calls: The missions that pass it, one after the other; none: the robot drives on.
        rolls: By how much they turn the robot, side A up where the pipe is flat.
    """

    joints: Annotated[tuple[JointKind, ...], Field(min_length=1)]
    turns: bool | None = None
    towards: tuple[Angle, ...] = ()
    calls: tuple[str, ...] = ()
    rolls: Angle = 0.0

    def passes(self, kind: JointKind, turns: bool, towards_rad: float) -> bool:
        """Return whether this passes a joint of a kind that turns towards a direction."""
        if kind not in self.joints or (self.turns is not None and self.turns != turns):
            return False
        off = (abs(remainder(towards_rad - each, 2 * pi)) for each in self.towards)
        return not self.towards or any(angle <= _OFF_RAD for angle in off)


class Travel(Frozen):
    """The missions that a mission along a route is made of; each begins and ends in one state.

    Attributes:
        starts_in: This state of the robot.
        last: The mission that drives on to the end of the route; its parameter `way` says how far.
        passages: What passes the joints; the first that fits is taken.
    """

    starts_in: dict[str, str] = {}
    last: str
    passages: tuple[PassedBy, ...] = ()
