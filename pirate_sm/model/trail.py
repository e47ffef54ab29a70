"""Where a robot was at each of many steps of a run that were taken at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from pirate_sm.model.true_position import InSpace


class Stood(NamedTuple):
    """Where a robot was at one time.

    Attributes:
        places_m: x and y of each wheel in turn, in the plane of the drawing, m.
        space: What they leave out.
    """

    places_m: tuple[float, ...]
    space: InSpace

    @property
    def wheels(self) -> tuple[tuple[float, float], ...]:
        """Return the position of each wheel in that plane, m."""
        numbers = iter(self.places_m)
        return tuple(zip(numbers, numbers, strict=True))


class Trail(NamedTuple):
    """Where a robot was. It cannot be asked once more steps are taken at once.

    Attributes:
        until_s: Time of the last step, in seconds since the run began.
        where: Returns where the robot was at the time of a step.
    """

    until_s: float
    where: Callable[[float], Stood]

    def at(self, now_s: float) -> Stood | None:
        """Return where the robot was at the time of a step; None after the last: where it is."""
        return self.where(now_s) if now_s <= self.until_s else None
