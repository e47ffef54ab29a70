"""The frames of a robot's parts, each relative to the one before it, as Foxglove messages.

Names and positions are those of the robot's URDF: a link's frame is at its front wheel with x
ahead, a link with a roll joint inside has a second frame in its middle, wheels turn about z. In a
round pipe the first link has six degrees of freedom, and the frame of the drawing is turned in a
frame ``world`` whose z axis goes up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import atan2, cos, isfinite, sin, sqrt
from typing import Any, Literal, NamedTuple

from pirate_sm.core.events import InSpace
from pirate_sm.core.geometry import (
    DRAWING,
    Frame,
    Place,
    Pose,
    Route,
    Vector,
    combined,
    crossed,
    dot,
)
from pirate_sm.core.models import Body
from pirate_sm.running.recording.viewers.pipe_walls import part_normals, seen_in, unit, upright

# --- in a plane -----------------------------------------------------------------------------------


PIPE = "pipe"
"""The frame of the plane of the pipe."""


class LinkFrame(NamedTuple):
    """A frame that turns about one axis of its parent frame.

    Attributes:
        name: Name of the frame.
        parent: Its parent frame.
        x_m: Its position on the parent's x axis; for the first link the pose gives it.
        axis: The axis that it turns about.
        turned_by: ``bend``: the difference in heading of two links. Otherwise a signal.
    """

    name: str
    parent: str
    x_m: float
    axis: Literal["x", "z"]
    turned_by: str


BEND = "bend"


def frames_of(body: Body) -> tuple[LinkFrame, ...]:
    """Return every frame, each after its parent."""
    frames: list[LinkFrame] = []
    parent, behind = PIPE, 0.0
    for number, link in enumerate(body.links):
        frames.append(LinkFrame(link.module, parent, behind, "z", BEND))
        wheel = body.wheels[number]
        frames.append(LinkFrame(wheel.name, link.module, 0.0, "z", wheel.angle))
        parent, behind = link.module, -link.length
        if link.roll is not None:
            parent, behind = f"{link.module}_rear", -link.length / 2
            frames.append(LinkFrame(parent, link.module, behind, "x", link.roll))
    last = body.wheels[len(body.links)]
    frames.append(LinkFrame(last.name, parent, behind, "z", last.angle))
    return tuple(frames)


class Transforms:
    """Writes the poses of all frames; the text is prepared once because it is written often."""

    def __init__(self, body: Body) -> None:
        self._frames = frames_of(body)
        self._text = '{"transforms":[' + ",".join(map(_layout, self._frames)) + "]}"

    def message(self, stamp: str, poses: Sequence[Pose], angles: Mapping[str, float]) -> bytes:
        """Return a ``foxglove.FrameTransforms`` as JSON.

        Args:
            stamp: The time as JSON.
            poses: Pose of each link in the plane of the pipe.
            angles: Angles of wheels and roll joints by signal, rad; unknown ones are 0.
        """
        values: list[object] = []
        before, links = 0.0, iter(poses)
        for frame in self._frames:
            values.append(stamp)
            if frame.turned_by == BEND:
                pose = next(links)
                if frame.parent == PIPE:
                    values += (pose.x_m, pose.y_m)
                half = (pose.heading_rad - before) / 2
                before = pose.heading_rad
            else:
                angle = angles.get(frame.turned_by, 0.0)
                half = angle / 2 if isfinite(angle) else 0.0
            values += (sin(half), cos(half))
        return (self._text % tuple(values)).encode()


def _layout(frame: LinkFrame) -> str:
    """Return the text of one transform with gaps for time, position (if it moves) and angle."""
    names = f'"parent_frame_id":"{frame.parent}","child_frame_id":"{frame.name}"'
    place = '"x":%.7g,"y":%.7g' if frame.parent == PIPE else f'"x":{frame.x_m!r},"y":0'
    turned = '"x":%.7g,"y":0,"z":0' if frame.axis == "x" else '"x":0,"y":0,"z":%.7g'
    return (
        f'{{"timestamp":%s,{names},"translation":{{{place},"z":0}},'
        f'"rotation":{{{turned},"w":%.7g}}}}'
    )


# --- rotations ------------------------------------------------------------------------------------


class Quaternion(NamedTuple):
    """A rotation; all four are 0, 0, 0, 1 without one."""

    x: float
    y: float
    z: float
    w: float

    @property
    def json(self) -> dict[str, Any]:
        """Return it as JSON."""
        return self._asdict()


def about(axis: Literal["x", "z"], angle_rad: float) -> Quaternion:
    """Return the rotation about a coordinate axis."""
    half = angle_rad / 2
    if axis == "x":
        return Quaternion(sin(half), 0.0, 0.0, cos(half))
    return Quaternion(0.0, 0.0, sin(half), cos(half))


def of_axes(x: Vector, y: Vector, z: Vector) -> Quaternion:
    """Return the rotation that takes the coordinate axes to three orthogonal unit vectors.

    By the largest of the four numbers (S. W. Shepperd, 1978), so that none is divided by a small
    one.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = x, y, z
    trace = xx + yy + zz
    squares = (1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz, 1.0 + trace)
    largest = squares.index(max(squares))
    s = 2.0 * sqrt(squares[largest])
    if largest == 0:
        return Quaternion(s / 4, (xy + yx) / s, (xz + zx) / s, (yz - zy) / s)
    if largest == 1:
        return Quaternion((xy + yx) / s, s / 4, (yz + zy) / s, (zx - xz) / s)
    if largest == 2:
        return Quaternion((xz + zx) / s, (yz + zy) / s, s / 4, (xy - yx) / s)
    return Quaternion((yz - zy) / s, (zx - xz) / s, (xy - yx) / s, s / 4)


# --- in space -------------------------------------------------------------------------------------


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
        """Return the axes of each frame of a link in its part's plane."""
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


def link_poses(places: Sequence[Place]) -> tuple[Pose, ...]:
    """Return the pose of each link from the positions of the wheels."""
    return tuple(Pose(ax, ay, atan2(ay - by, ax - bx)) for (ax, ay), (bx, by) in pairwise(places))
