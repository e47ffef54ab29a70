"""The robot in its pipe over time, by a simulator or by dead reckoning, in a plane or in space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import InSpace
from pirate_sm.core.geometry import Place, Route, drawn_walls
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.core.robot import RobotSpec, RobotState, confirmed_parts
from pirate_sm.running.recording.signal_names import add_evenly
from pirate_sm.running.recording.viewers.pipe_walls import (
    part_normals,
    seen_in,
    upright,
    walls_in_space,
)
from pirate_sm.running.recording.viewers.viewer_messages import WheelPlacing
from pirate_sm.views.drawing.pipe_views import centre_line, named_points, sides
from pirate_sm.views.report.charts import Samples, TravelChart
from pirate_sm.views.report.contents import (
    DrawnWheel,
    Lane,
    Light,
    RobotScene,
    Series,
    SpaceScene,
    Span,
)

# --- in space -----------------------------------------------------------------------------------


def space_scene(
    points: Sequence[Sequence[Place]], spaces: Sequence[InSpace], profile: Profile, route: Route
) -> SpaceScene:
    """Return the scene.

    Args:
        points: At each time the position of each wheel in the plane of the drawing, m.
        spaces: What these leave out.
        profile: The robot's profile.
        route: The route through the pipes.
    """
    frame = upright(route.up)
    drawn = [
        tuple((x, y, z) for (x, y), z in zip(wheels, space.z_m, strict=True))
        for wheels, space in zip(points, spaces, strict=True)
    ]
    rear = profile.body.first_behind_roll
    planes = [
        part_normals(route, wheels, rear, space.rolls_rad[1:])
        for wheels, space in zip(drawn, spaces, strict=True)
    ]
    return SpaceScene(
        poses=[tuple(seen_in(frame, point) for point in wheels) for wheels in drawn],
        normals=[(seen_in(frame, front), seen_in(frame, behind)) for front, behind in planes],
        rear=rear,
        wheel_width_m=profile.body.wheel_width,
        walls=tuple(
            tuple(tuple(seen_in(frame, point) for point in ring) for ring in rings)
            for rings in walls_in_space(route.network, route.placement)
        ),
        sides=sides(route, frame),
        way=tuple(centre_line(route, frame)),
        names=tuple(named_points(route, frame)),
    )


# --- in a plane ---------------------------------------------------------------------------------


MOST_POSES = 6_000
_MOST_KEPT = 40_000
"""The most poses in memory, however long a run is: those of an hour of simulation."""

EVERY_S = 0.05
"""Interval of the poses: the page interpolates between them."""


class SampledPose(NamedTuple):
    """The robot at one time.

    Attributes:
        points: Position of each wheel in the plane of the drawing.
        space: What these leave out of a robot in space; None if unknown.
    """

    points: tuple[Place, ...]
    space: InSpace | None = None


@dataclass
class Poses:
    """The robot over time.

    Attributes:
        true: Whether they are a simulator's true positions.
        times_s: The time of each pose.
        kept: The poses.
    """

    true: bool
    times_s: list[float] = field(default_factory=list)
    kept: list[SampledPose] = field(default_factory=list)
    _apart_s: float = field(default=0.0, repr=False)

    @property
    def points(self) -> list[tuple[Place, ...]]:
        """Return the positions of the wheels in the plane of the drawing."""
        return [pose.points for pose in self.kept]

    @property
    def spaces(self) -> list[InSpace]:
        """Return what they leave out; empty unless it is known of all poses."""
        found = [pose.space for pose in self.kept if pose.space is not None]
        return found if len(found) == len(self.kept) else []

    def add(self, at_s: float, points: Sequence[Place], space: InSpace | None = None) -> None:
        """Add a pose; it replaces one of the same time.

        Of a large number some are dropped, evenly, but not the newest.
        """
        new = at_s, SampledPose(tuple(points), space)
        self._apart_s = add_evenly(self.times_s, self.kept, new, self._apart_s, _MOST_KEPT)

    def thinned(self, most: int = MOST_POSES) -> Poses:
        """Return at most this many poses, evenly spaced, with the last one."""
        step = -(-len(self.times_s) // most) or 1
        chosen = sorted({*range(0, len(self.times_s), step), *range(len(self.times_s))[-1:]})
        return Poses(self.true, [self.times_s[n] for n in chosen], [self.kept[n] for n in chosen])


class ReckonedPath:
    """Follows a robot by dead reckoning while its engine is replayed.

    Args:
        placing: Returns the positions of the wheels.
    """

    def __init__(self, placing: WheelPlacing) -> None:
        self.poses = Poses(true=False)
        self._placing = placing
        self._due_s = 0.0

    def look(self, state: EngineState, now_s: float) -> None:
        """Update the positions of the wheels, if it is time for the next pose."""
        if now_s >= self._due_s:
            points = self._placing.look(state, now_s)
            if points is not None:
                self._due_s = now_s + EVERY_S
                self.poses.add(now_s, points)


Arcs: TypeAlias = tuple[float, ...]
"""How far along the pipe each wheel is, m."""


def travel_of(
    poses: Poses, pipe: Pipe | None, known: dict[SampledPose, Arcs] | None = None
) -> TravelChart | None:
    """Return the distances of the wheels and their middle along the pipe; None if unknown.

    Args:
        poses: The robot over time.
        pipe: The pipe.
        known: Keeps what was found of each pose for a call with more of them.
    """
    if pipe is None or not poses.times_s:
        return None
    route, times, known = pipe.route(), poses.times_s, {} if known is None else known
    for pose in poses.kept:
        if pose not in known:
            heights = pose.space.z_m if pose.space else repeat(0.0)
            known[pose] = tuple(
                route.arc_of((x, y, z)) for (x, y), z in zip(pose.points, heights, strict=False)
            )
    places = [known[pose] for pose in poses.kept]
    middles = [sum(each) / len(each) for each in places]
    distance = [middle - middles[0] for middle in middles]
    name = "really" if poses.true else "reckoned"
    wheels = tuple(Series("", times, list(each)) for each in zip(*places, strict=True))
    return TravelChart(poses.true, Series(name, times, distance, main=True), wheels)


def scene_of(
    poses: Poses,
    profile: Profile,
    robot: RobotSpec,
    pipe: Pipe | None,
    signals: Samples,
    setpoints: Samples,
    held: Sequence[Lane],
) -> RobotScene | None:
    """Return the scene with everything drawn on the robot; None without any position."""
    if not poses.times_s:
        return None
    thin, body = poses.thinned(), profile.body
    wheels = []
    for wheel, spec in zip(body.wheels, robot.wheels, strict=True):
        forward = 1.0 if spec.metres_per_rad > 0 else -1.0
        angle = signals.series(spec.angle, wheel.name)
        drive = setpoints.series(spec.slot, wheel.name, scale=forward, stepped=True)
        wheels.append(DrawnWheel(wheel.name, wheel.part, angle, drive))
    source: Literal["truth", "reckoned"] = "truth" if poses.true else "reckoned"
    route, spaces = pipe.route() if pipe is not None else None, thin.spaces
    walls = drawn_walls(route) if route is not None else ()
    space = space_scene(thin.points, spaces, profile, route) if spaces and route else None
    seen = source, thin.times_s, thin.points, walls, tuple(wheels)
    sizes = body.wheel_radius, body.body_half_thickness
    return RobotScene(*seen, *sizes, tuple(held), _lights(profile, setpoints), space)


def _lights(profile: Profile, setpoints: Samples) -> tuple[Light, ...]:
    """Return each light in the middle of its module, or at the end of the chain of its board."""
    modules = {link.module: number for number, link in enumerate(profile.body.links)}
    links = [number for number, board in enumerate(profile.boards) if board.module in modules]
    lights, index = [], 0
    for number, board in enumerate(profile.boards):
        for slot in board.slots:
            if profile.motors[slot.motor].kind == "light":
                if board.module in modules:
                    at = (modules[board.module] + 0.5) / len(modules)
                else:
                    at = 0.0 if not links or number < links[0] else 1.0
                lights.append(
                    Light(slot.name, at, setpoints.series(index, slot.name, stepped=True))
                )
            index += 1
    return tuple(lights)


class Holding:
    """The times during which each part held, and whether that was confirmed."""

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        self._since: dict[int, tuple[float, bool]] = {}
        self._spans: list[list[Span]] = [[] for _ in robot.parts]
        self._seen: RobotState | None = None

    def look(self, state: EngineState, now_s: float) -> bool:
        """Note which parts hold now; return whether another one has been shown to."""
        if state.robot is self._seen:  # frames seldom change it
            return False
        self._seen, closed = state.robot, False
        held = self._robot.held[state.robot.configuration]
        confirmed = confirmed_parts(self._robot, state.robot) if held else held
        for part in range(len(self._robot.parts)):
            now = (part in confirmed) if part in held else None
            before = self._since.get(part)
            if (before[1] if before else None) is not now:
                closed |= now is True
                self._close(part, now_s)
                if now is not None:
                    self._since[part] = (now_s, now)
        return closed

    def lanes(self, until_s: float) -> tuple[Lane, ...]:
        """Return one lane for each part, until this time."""
        return tuple(
            Lane(name, (*spans, *self._held(part, until_s)))
            for part, (name, spans) in enumerate(zip(self._robot.parts, self._spans, strict=True))
        )

    def _close(self, part: int, at_s: float) -> None:
        self._spans[part] += self._held(part, at_s)
        self._since.pop(part, None)

    def _held(self, part: int, until_s: float) -> Iterator[Span]:
        """Yield the span in which the part has held so far, if it does."""
        if part in self._since:
            since_s, confirmed = self._since[part]
            if confirmed:
                yield Span(since_s, until_s, "held", "state")
            else:
                yield Span(since_s, until_s, "held, unconfirmed", "unconfirmed")
