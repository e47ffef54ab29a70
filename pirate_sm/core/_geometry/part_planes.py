"""The planes in which the two parts of a robot in space lie, from its rolls."""

from __future__ import annotations

from collections.abc import Sequence

from pirate_sm.core._geometry.route import Route
from pirate_sm.core._geometry.space import Vector, combined, dot, scaled


def part_normals(
    route: Route, points: Sequence[Vector], rear: int, rolls_rad: Sequence[float]
) -> tuple[Vector, Vector]:
    """Return the unit normals of the front and of the rear part, square to the link between them.

    Args:
        route: The route through the pipes.
        points: Position of each wheel in the frame of the drawing, m.
        rear: Index of the first wheel of the rear part.
        rolls_rad: Roll of the front and of the rear part against the frame of the pipe where the
            link between them begins and ends.
    """
    ahead = unit(combined((1.0, points[rear - 1]), (-1.0, points[rear])))
    front, behind = (
        _square(route.frame_at(route.arc_of(points[wheel])).rolled(roll_rad).normal, ahead)
        for wheel, roll_rad in zip((rear - 1, rear), rolls_rad, strict=True)
    )
    return front, behind


def unit(vector: Vector) -> Vector:
    """Return the vector with length 1."""
    return scaled(dot(vector, vector) ** -0.5, vector)


def _square(vector: Vector, ahead: Vector) -> Vector:
    """Return the unit vector square to ``ahead`` that is nearest to a unit vector.

    A pipe that turns by a right angle within the link leaves none; then it stays as it is.
    """
    across = combined((1.0, vector), (-dot(vector, ahead), ahead))
    return unit(across) if dot(across, across) > 0.0 else vector
