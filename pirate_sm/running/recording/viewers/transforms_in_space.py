"""The frames of a robot in a round pipe: its first link has six degrees of freedom.

The frame of the drawing is turned in a frame ``world`` whose z axis goes up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite

from pirate_sm.core.geometry import (
    DRAWING,
    Frame,
    Route,
    Vector,
    combined,
    crossed,
    dot,
    part_normals,
    seen_in,
    unit,
    upright,
)
from pirate_sm.core.profile import Body
from pirate_sm.core.simulation import InSpace
from pirate_sm.running.recording.viewers.quaternions import Quaternion, about, of_axes
from pirate_sm.running.recording.viewers.transforms import BEND, PIPE, frames_of

WORLD = "world"


class SpaceTransforms:
    """Writes the poses of all frames of a robot in space.

    Args:
        body: The robot's body.
        route: The route through the pipes.
    """

    def __init__(self, body: Body, route: Route) -> None:
        self._frames = frames_of(body)
        self._route = route
        self._rear = body.first_behind_roll
        level = upright(route.up)
        self._root = of_axes(*(seen_in(level, axis) for axis in DRAWING[1:]))

    def message(
        self, stamp: str, points: Sequence[Vector], space: InSpace, angles: Mapping[str, float]
    ) -> bytes:
        """Return a ``foxglove.FrameTransforms`` as JSON.

        Args:
            stamp: The time as JSON.
            points: Position of each wheel in the frame of the drawing, m.
            space: The rolls of the parts.
            angles: Angles of wheels by signal, rad; unknown ones are 0.
        """
        rolls = space.rolls_rad[1:]
        axes = self._axes(points, part_normals(self._route, points, self._rear, rolls))
        found = [_transform(stamp, WORLD, PIPE, (0.0, 0.0, 0.0), self._root)]
        for frame in self._frames:
            own = axes.get(frame.name)
            if own is None:
                angle = angles.get(frame.turned_by, 0.0)
                turned = about("z", angle if isfinite(angle) else 0.0)
            else:
                parent = axes.get(frame.parent, DRAWING)
                turned = of_axes(*(seen_in(parent, axis) for axis in own[1:]))
            place = points[0] if frame.parent == PIPE else (frame.x_m, 0.0, 0.0)
            found.append(_transform(stamp, frame.parent, frame.name, place, turned))
        return f'{{"transforms":[{",".join(found)}]}}'.encode()

    def _axes(self, points: Sequence[Vector], normals: tuple[Vector, Vector]) -> dict[str, Frame]:
        """Return the axes of each frame of a link, as it stands in its part's plane."""
        found, link = {}, -1
        for frame in self._frames:
            if frame.axis == "x":
                found[frame.name] = _standing(points[link], points[link + 1], normals[1])
            elif frame.turned_by == BEND:
                link += 1
                normal = normals[link >= self._rear]
                found[frame.name] = _standing(points[link], points[link + 1], normal)
        return found


def _standing(front: Vector, behind: Vector, normal: Vector) -> Frame:
    """Return the frame of a link from its two wheels and the normal of its part."""
    ahead = unit(combined((1.0, front), (-1.0, behind)))
    square = unit(combined((1.0, normal), (-dot(normal, ahead), ahead)))
    return Frame(front, ahead, crossed(square, ahead), square)


def _transform(stamp: str, parent: str, child: str, place: Vector, turned: Quaternion) -> str:
    names = f'"parent_frame_id":"{parent}","child_frame_id":"{child}"'
    x, y, z = place
    qx, qy, qz, qw = turned
    return (
        f'{{"timestamp":{stamp},{names},"translation":{{"x":{x:.7g},"y":{y:.7g},"z":{z:.7g}}},'
        f'"rotation":{{"x":{qx:.7g},"y":{qy:.7g},"z":{qz:.7g},"w":{qw:.7g}}}}}'
    )
