"""Where a robot is: as a camera saw it, and as its simulator knows it.

A trail says where it was at each of many steps that a run has made together. A detector by
positions shares what it knows, so that others can look while it has nothing to say.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import nan
from typing import NamedTuple, TypeAlias

from pirate_sm.core._geometry.space import Vector


@dataclass(frozen=True)
class SeenMark:
    """A tag or marker of the robot, found in a frame.

    Attributes:
        on: The module that it is fixed to, as in the camera's file.
        place_m: Its centre in the plane of the setup, m. The origin is the inner corner of the
            bend, x points along the first leg of the pipe, y to side A (thesis section 5-3-2).
        heading_rad: Direction in which the module points ahead, from x towards y; None for a
            marker, which is round.
    """

    on: str
    place_m: tuple[float, float]
    heading_rad: float | None = None


@dataclass(frozen=True)
class Sighting:
    """What was found in one frame.

    Attributes:
        captured_s: Time at which the light fell on the sensor: the frame's arrival minus the
            camera's latency, s.
        marks: What was found of the robot, in the order of the camera's file.
        rms_px: How far the setup's tags are from where the survey expects them, root mean square,
            px; None if fewer than two of them are seen.
        gray_spread: Difference between the 5 % darkest and the 5 % brightest pixels, of 255.
        digest: A checksum of the pixels; equal in identical frames.
    """

    captured_s: float
    marks: tuple[SeenMark, ...]
    rms_px: float | None
    gray_spread: float
    digest: int


class InSpace(NamedTuple):
    """What the places of a robot's wheels in a plane leave out of a robot in space.

    Attributes:
        z_m: Third coordinate of each wheel, across the plane of the drawing.
        rolls_rad: As in :class:`Truth`.
    """

    z_m: tuple[float, ...]
    rolls_rad: tuple[float, ...]


@dataclass(frozen=True)
class Truth:
    """The robot's true position in its pipe, for views and reports; no controller may use it.

    Attributes:
        wheels: Position of each wheel in the plane of the drawing, m.
        wheel_radius_m: Radius of the wheels.
        walls: Corners of each wall in the same plane, m: side A, then side B; empty for a pipe that
            does not lie in it.
        distance_m: The robot's position along the pipe.
        touching: Whether each wheel presses on a wall; empty if unknown.
        rolls_rad: Angle of the roll joint, then the roll of the front and of the rear part
            relative to the frame of the pipe where they are; empty if unknown.
        z_m: Third coordinate of each wheel, across that plane; empty if the robot moves in it.
        run: The run of the pipe in which the first wheel is; empty if unknown.
        arc_m: Position of the first wheel along the route; NaN if unknown.
    """

    wheels: tuple[tuple[float, float], ...]
    wheel_radius_m: float
    walls: tuple[tuple[tuple[float, float], ...], ...]
    distance_m: float
    touching: tuple[bool, ...] = ()
    rolls_rad: tuple[float, ...] = ()
    z_m: tuple[float, ...] = ()
    run: str = ""
    arc_m: float = nan

    @property
    def points(self) -> tuple[Vector, ...]:
        """Return the position of each wheel in space, in the frame of the drawing, m."""
        return tuple(
            (x, y, z)
            for (x, y), z in zip(self.wheels, self.z_m or (0.0,) * len(self.wheels), strict=True)
        )


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

    @classmethod
    def of(cls, row: tuple[Sequence[float], Sequence[float], Sequence[float]]) -> Stood:
        """Return it from a row of :class:`Whereabouts`."""
        places_m, z_m, rolls_rad = map(tuple, row)
        return cls(places_m, InSpace(z_m, rolls_rad))

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
        return Stood.of(next(zip(*self.read([self.noted([now_s])]), strict=True)))


Look: TypeAlias = tuple[float, ...]
"""A time, then where each wheel was along the pipe."""


class WordWatch(NamedTuple):
    """What a detector knows between two looks; see :mod:`pirate_sm.robot.detectors.word_timing`.

    Attributes:
        places_m: Returns the position of each wheel along the pipe.
        due_s: When it looks next; ``every_s``: how long after each look it looks again.
        seen: The looks by which a position is filtered.
        driven: Whether wheels are driven.
        direction: In which direction they were driven last: 1 forward, -1 backward, 0 never.
        points: Per word, the farthest first, its wheel and what is added to how far the wheel is
            beyond a crossing; the word begins where the sum is 0.
        bends: The bends along the pipe, and how far each reaches: with the last of the points its
            words begin so much earlier, with the others so much later.
        word: Index of the present word among the points; -1 without one. ``name``: the word.
        valid_for_s: How long it is valid.
        said_s: When it was said; ``repeat_s``: after which time it is said again, infinite without
            a word.
    """

    places_m: Callable[[], Sequence[float]]
    due_s: float
    every_s: float
    seen: Sequence[Look]
    driven: bool
    direction: int
    points: tuple[tuple[int, float], ...]
    bends: tuple[tuple[float, float], ...]
    word: int
    name: str
    valid_for_s: float
    said_s: float
    repeat_s: float
