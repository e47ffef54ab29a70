"""The points of a mission's course, the bends it makes there, and what turns its parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from pirate_sm.checking.actuation_in_force import Actuated
from pirate_sm.checking.pipe.bends import BentPart
from pirate_sm.checking.pipe.roll_joint import PartRolls


class CoursePoint(NamedTuple):
    """A point in the course of a mission.

    Attributes:
        at: Index of the next instruction.
        configuration: Index into the chart's table.
        bent: Parts that have been bent into the present bend so far, in order.
        control: Index of the control in force.
        driven: Whether wheels have been driven so far.
        way: Direction in which they were driven last, 1 forward, -1 backward; 0 if unknown.
        passed: How many bends the robot has passed forward, less those backward; without the
            present one.
        rolls: How the parts are rolled; None if unknown.
        wound: Parts that are relaxed with their worms wound.
        place: Place of the step that led to the configuration or to the control; empty at the
            start.
    """

    at: int
    configuration: int
    bent: tuple[int, ...]
    control: int = 0
    driven: bool = False
    way: int = 0
    passed: int = 0
    rolls: PartRolls | None = PartRolls()
    wound: frozenset[int] = frozenset()
    place: str = ""

    @property
    def actuated(self) -> Actuated:
        """Return the configuration with the control in force."""
        return Actuated(self.configuration, self.control)


class Change(NamedTuple):
    """A command that changes the configuration.

    Attributes:
        command: Index of the command.
        before: The point before it.
        after: The point after it, whose place is that of the step.
    """

    command: int
    before: CoursePoint
    after: CoursePoint


class Bending(NamedTuple):
    """A part that is bent into a bend of the pipe.

    Attributes:
        bend: Which part, and to which side.
        point: The point at which it is bent; its place is empty for a bend at the start.
        joint: Into which bend, counted from the robot's start: 0 is the first ahead of it, -1 the
            first behind it.
        roll: Roll of the part in quarter turns; None if unknown.
    """

    bend: BentPart
    point: CoursePoint
    joint: int
    roll: float | None


@dataclass(frozen=True)
class UsualCourse:
    """The course of a mission without failures.

    Attributes:
        situations: All points of the course, in breadth-first order.
        bends: The distinct bends.
        turns: The commands that turn the roll joint, each from a point of its own.
        came: The point from which each point was reached first.
        leads: Of each part the direction in which it leads: 1 forward, -1 backward, 0 in neither.
        onward: The points that may follow each point, by its fields without the place.
    """

    situations: tuple[CoursePoint, ...]
    bends: tuple[Bending, ...]
    turns: tuple[Change, ...]
    came: Mapping[CoursePoint, CoursePoint]
    leads: tuple[int, ...]
    onward: Mapping[tuple[object, ...], tuple[CoursePoint, ...]]

    def way_to(self, point: CoursePoint) -> tuple[CoursePoint, ...]:
        """Return the points with a step of their own that lead to a point, in order."""
        found = [point]
        while found[-1] in self.came:
            found.append(self.came[found[-1]])
        steps = [
            after
            for before, after in zip(found[1:], found, strict=False)
            if after.place != before.place
        ]
        return tuple(reversed(steps))
