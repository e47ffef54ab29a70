"""The frames of a robot's parts and where each is in the one before it, as Foxglove writes it.

Names and places are those of the robot's URDF: a link's frame sits at its front wheel with x
ahead, a link with a roll joint inside has a second one in its middle, wheels turn about z.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, isfinite, sin
from typing import Literal, NamedTuple

from pirate_sm.geometry.kinematics import Pose
from pirate_sm.model.body import Body

PIPE = "pipe"
"""The frame of the plane in which the pipe lies."""


class LinkFrame(NamedTuple):
    """A frame that turns about one axis of the frame it stands in.

    Attributes:
        name: Name of the frame.
        parent: The frame that it stands in.
        x_m: Its place on the parent's x axis; of the first link the pose says that.
        axis: What it turns about.
        turned_by: ``bend``: how much two links differ in heading. Else a signal.
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
    """Writes where every frame is; the text is prepared once because it is written often."""

    def __init__(self, body: Body) -> None:
        self._frames = frames_of(body)
        self._text = '{"transforms":[' + ",".join(map(_layout, self._frames)) + "]}"

    def message(self, stamp: str, poses: Sequence[Pose], angles: Mapping[str, float]) -> bytes:
        """Return a ``foxglove.FrameTransforms`` as JSON.

        Args:
            stamp: The time as JSON.
            poses: Of each link in the plane of the pipe.
            angles: Of wheels and roll joints by signal, rad; unknown ones are 0.
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
    """Return the text of one transform with gaps for time, place (if it moves) and angle."""
    names = f'"parent_frame_id":"{frame.parent}","child_frame_id":"{frame.name}"'
    place = '"x":%.7g,"y":%.7g' if frame.parent == PIPE else f'"x":{frame.x_m!r},"y":0'
    turned = '"x":%.7g,"y":0,"z":0' if frame.axis == "x" else '"x":0,"y":0,"z":%.7g'
    return (
        f'{{"timestamp":%s,{names},"translation":{{{place},"z":0}},'
        f'"rotation":{{{turned},"w":%.7g}}}}'
    )
