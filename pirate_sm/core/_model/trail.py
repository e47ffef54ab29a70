"""Where a robot was at each of many steps of a run that were taken at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from pirate_sm.core._model.true_position import InSpace

Rows = Sequence[Sequence[float]]
"""A row of numbers for each of several times."""


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


class Whereabouts(NamedTuple):
    """Where a robot was at several times.

    Attributes:
        places_m: x and y of each wheel in turn, in the plane of the drawing, m.
        z_m: z of each wheel, m; empty rows of a robot in a plane.
        rolls_rad: Angle of the roll joint, rolls of the front and of the rear part, rad.
    """

    places_m: Rows
    z_m: Rows
    rolls_rad: Rows


class Trail(NamedTuple):
    """Where a robot was. It cannot be asked once more steps are taken at once.

    Attributes:
        until_s: Time of the last step, in seconds since the run began.
        noted: Returns what was noted at the times of some steps, which can be kept; as bytes it is
            nothing that Python's garbage collector looks at.
        read: Returns where the robot was, from what several calls of ``noted`` have returned.
    """

    until_s: float
    noted: Callable[[Sequence[float]], bytes]
    read: Callable[[Sequence[bytes]], Whereabouts]

    def at(self, now_s: float) -> Stood | None:
        """Return where the robot was at the time of a step; None after the last: where it is."""
        if now_s > self.until_s:
            return None
        (places_m,), (z_m,), (rolls_rad,) = self.read([self.noted([now_s])])
        return Stood(tuple(places_m), InSpace(tuple(z_m), tuple(rolls_rad)))
