"""The frames of a robot's parts, each relative to the one before it, as Foxglove messages.

Names and positions are those of the robot's URDF: a link's frame is at its front wheel with x
ahead, a link with a roll joint inside has a second frame in its middle, wheels turn about z.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, isfinite, sin
from typing import Literal, NamedTuple

from pirate_sm.core.geometry import Pose
from pirate_sm.core.profile import Body

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
