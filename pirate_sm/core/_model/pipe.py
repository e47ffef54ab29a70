"""Pipes: one run in a plane, or a network of round pipes in space, with data for simulators."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from math import cos, sin
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import BeforeValidator, Field, model_validator

from pirate_sm.core._geometry import network as space
from pirate_sm.core._geometry.network import Piece
from pirate_sm.core._geometry.route import Route, RouteJoint
from pirate_sm.core._geometry.space import Vector
from pirate_sm.core._model.base import Format, Frozen, Name
from pirate_sm.core._model.pipe_runs import (
    Expanded,
    Junction,
    KeyPath,
    Patch,
    PipeRun,
    Roll,
    SegmentOrTee,
    Straight,
    Written,
    expanded,
    within,
)
from pirate_sm.core._model.quantities import Angle, Duration, Length, PositiveDuration, key_fault
from pirate_sm.core._model.robot.simulation import Coefficients, Friction


class Blockage(Frozen):
    """An obstacle ``at`` a position that disappears after being pushed for ``lasting``.

    Attributes:
        at: Position along the axis, from the beginning of the pipe.
        lasting: How long it withstands a push before it is removed.
        from_s: Mission time at which it appears.
    """

    at: Annotated[Length, Field(ge=0)]
    lasting: Annotated[Duration, Field(ge=0)]
    from_s: Annotated[Duration, Field(alias="from", ge=0)] = 0.0


class Turns(Frozen):
    """The plane of the pipe is turned, at one rate, from its tilt to another one.

    Attributes:
        from_s: When it begins to turn, in mission time.
        to: When it has turned.
        tilt: The tilt that it then has; ``uphill`` stays.
    """

    from_s: Annotated[Duration, Field(alias="from", ge=0)]
    to: PositiveDuration
    tilt: Annotated[Angle, within(90)]

    @model_validator(mode="after")
    def _takes_time(self) -> Turns:
        if self.to <= self.from_s:
            raise ValueError("`to` must be later than `from`")
        return self


class Start(Frozen):
    """The start of a simulated robot: the position of its first wheel along the axis.

    Attributes:
        at: Position of the robot's first wheel along the axis, from the beginning of the pipe, or
            of its run.
        run: The run in which it starts; by default the first of the route.
        roll: Roll of the robot about the axis, in a round pipe, against the frame of the pipe
            there: 90 deg has side A up where the run is flat.
    """

    at: Annotated[Length, Field(ge=0)]
    run: Name | None = None
    roll: Roll = 0.0


class Attitude(Frozen):
    """How the first run of a round pipe lies.

    Attributes:
        pitch: Angle by which it climbs in the direction of travel.
        roll: Roll of its frame, against which the fittings are rolled.
    """

    pitch: Annotated[Angle, within(90)] = 0.0
    roll: Roll = 0.0

    @property
    def up(self) -> Vector:
        """Return the unit vector against gravity, in the frame of the first run."""
        pitch, roll = self.pitch, self.roll
        return sin(pitch), cos(pitch) * sin(roll), -cos(pitch) * cos(roll)


class FrictionStretch(NamedTuple):
    """A stretch of a route with friction of its own.

    Attributes:
        from_m: Arc length of the route where it begins.
        to_m: Where it ends.
        friction: The coefficients.
    """

    from_m: float
    to_m: float
    friction: Coefficients


def _has_runs(value: object) -> object:
    """Return the value; raise an error that says what a run is if there is none."""
    if value == {}:
        run = "`main: {from: entry, to: exit, segments: [{straight: 1 m}]}`"
        raise key_fault("there is no run here", expected=f"at least one run, such as {run}")
    return value


class Pipe(Frozen):
    """A pipe in one plane, or a network of round pipes in space.

    Attributes:
        format: Version of this format.
        pipe: Name of the pipe.
        description: One-line description.
        diameter: Inner diameter; with ``runs``, of those that give none.
        tilt: Tilt of the pipe's plane against the horizontal; gravity has the component g sin(tilt)
            in the plane.
        uphill: Uphill direction in the tilted plane, measured from the axis of the first segment
            towards side A. 0 deg: the first segment goes up. 90 deg: a leg behind a mitre of
            +90 deg goes up.
        frame: How the first run lies, instead of tilt and uphill.
        roll: Roll of the pipe's plane about the axis of its first segment, relative to the robot's
            plane.
        segments: Straights, joined by fittings.
        runs: The runs of a network by name, instead of segments; the first fixes its frame.
        junctions: The tees by name.
        ends: The other places where runs begin or end: whether the pipe is open there.
        routes: By name the runs that a route leads through, in order.
        friction: Friction of the wall; overrides the robot's values.
        start: Start of a simulated robot; by default in the middle of the first segment.
        blockages: Obstacles, along the route.
        section: What its walls are: ``bars``, two of them, between which the robot moves in a
            plane, or ``round``, in which it moves in space.
        turns: How gravity turns while the mission runs.
        patches: Stretches of the wall with friction of their own.
    """

    format: Format = 1
    pipe: Name | None = None
    description: str = ""
    diameter: Annotated[Length, Field(gt=0, le=10)]
    tilt: Annotated[Angle, within(90)] = 0.0
    uphill: Annotated[Angle, within(360)] = 0.0
    frame: Attitude | None = None
    roll: Roll = 0.0
    segments: Annotated[tuple[SegmentOrTee, ...], Field(min_length=1, max_length=100)] | None = None
    runs: (
        Annotated[
            dict[Name, PipeRun], Field(min_length=1, max_length=100), BeforeValidator(_has_runs)
        ]
        | None
    ) = None
    junctions: dict[Name, Junction] = {}
    ends: dict[Name, Literal["open", "closed"]] = {}
    routes: dict[Name, Annotated[tuple[Name, ...], Field(min_length=1)]] = {}
    friction: Friction | None = None
    start: Start | None = None
    blockages: tuple[Blockage, ...] = ()
    section: space.Section = "bars"
    turns: Turns | None = None
    patches: tuple[Patch, ...] = ()

    @model_validator(mode="after")
    def _has_one_form(self) -> Self:
        if (self.segments is None) == (self.runs is None):
            raise key_fault("a pipe has either `segments` or `runs`", "segments", "runs")
        if self.runs is None and (self.junctions or self.ends or self.routes):
            message = "`junctions`, `ends` and `routes` belong to a pipe with `runs`"
            raise key_fault(message, "junctions", "ends", "routes")
        if self.runs is not None and self.patches:
            raise key_fault("the patches of a pipe with `runs` belong in its runs", "patches")
        if self.frame is not None and (self.tilt or self.uphill or self.turns):
            message = "a pipe has either `frame`, or `tilt`, `uphill` and `turns`"
            raise key_fault(message, "frame", "tilt", "uphill", "turns")
        if self.turns is not None and self.turns.tilt == self.tilt:
            raise key_fault("it turns to the `tilt` that the pipe has already", "turns")
        return self

    @cached_property
    def written(self) -> Mapping[str, Written]:
        """Return the runs by name, also those that a list of segments stands for."""
        if self.runs is None:
            return self._expanded.runs
        return {
            name: Written(
                run.model_copy(update={"diameter": run.diameter or self.diameter}),
                ("runs", name, "segments"),
            )
            for name, run in self.runs.items()
        }

    @cached_property
    def _expanded(self) -> Expanded:
        return expanded(self.segments or (), self.diameter, self.patches)

    @property
    def tees(self) -> Mapping[str, float]:
        """Return the roll of each tee by name, rad."""
        found = self._expanded.tees if self.runs is None else self.junctions
        return {name: tee.roll for name, tee in found.items()}

    @property
    def ways(self) -> Mapping[str, tuple[str, ...]]:
        """Return the runs of each route by name; a single run is a route."""
        if self.runs is None:
            return {"main": self._expanded.route}
        return self.routes or dict.fromkeys(list(self.runs)[:1], tuple(self.runs)[:1])

    def along(self, route: str) -> Pipe:
        """Return the pipe with this route first, which is the one that is taken."""
        return self.model_copy(update={"routes": {route: self.ways[route], **self.ways}})

    def diameter_at_start(self, robot_length_m: float) -> float:
        """Return the inner diameter where a simulated robot starts, m."""
        return self.route().diameter_at(self.start_of(robot_length_m))

    def bores_m(self, robot_length_m: float) -> tuple[float, ...]:
        """Return the inner diameters along the first route, m: first where a robot starts."""
        pieces = self.route().pieces
        return self.diameter_at_start(robot_length_m), *(piece.diameter_m for piece in pieces)

    def network(self, wider_m: float = 0.0) -> space.Network:
        """Return the pipe as a network, all its diameters greater by ``wider_m``."""
        up = self.frame.up if self.frame else space.tilted_up(self.tilt, self.uphill)
        closed = {name for name, end in self.ends.items() if end == "closed"}
        closed |= {each.run.to for each in self.written.values() if each.run.to.startswith("cap_")}
        return space.Network(
            {name: self._in_space(each.run, wider_m) for name, each in self.written.items()},
            self.ways,
            up,
            {name: space.Tee(roll) for name, roll in self.tees.items()},
            frozenset(closed),
        )

    def _in_space(self, run: PipeRun, wider_m: float) -> space.NetworkRun:
        segments = tuple(each.in_space() for each in run.segments)
        wider = tuple(
            replace(each, to_m=each.to_m + wider_m) if isinstance(each, space.Reducer) else each
            for each in segments
        )
        diameter_m = (run.diameter or self.diameter) + wider_m
        return space.NetworkRun(diameter_m, wider, run.from_port, run.to, self.section)

    def route(self) -> Route:
        """Return the first route through the pipe."""
        return self._route

    @cached_property
    def _route(self) -> Route:
        return Route(self.network())

    def path_of(self, piece: Piece) -> KeyPath:
        """Return the path in the file of the first segment of a piece of a route."""
        written = self.written[piece.run]
        if written.run.to.startswith("cap_"):
            return written.at
        return (*written.at, written.first + piece.segment)

    def path_of_joint(self, route: Route, joint: RouteJoint) -> KeyPath:
        """Return the path in the file of a joint of a route: of its tee, or of its fitting."""
        if joint.junction and self.runs is not None:
            return ("junctions", joint.junction)
        own = [each for each in route.pieces if each.arc_m <= joint.arc_m <= each.ends_m]
        for piece in own:
            if piece.arc is not None or piece.ends_with_m != piece.diameter_m:
                return self.path_of(piece)
        *at, number = max(map(self.path_of, own), key=lambda path: int(path[-1]))
        return (*at, int(number) - 1) if joint.kind in ("mitre", "tee") else (*at, number)

    def stretches(self, route: Route) -> tuple[FrictionStretch, ...]:
        """Return the stretches of a route whose friction is not that of the pipe, in order."""
        return tuple(_stretches(self, route))

    def start_of(self, robot_length_m: float) -> float:
        """Return the start position of the first wheel along the route, m."""
        if self.start is None:
            first = next(iter(self.written.values())).run.segments[0]
            middle = 0.5 * first.straight if isinstance(first, Straight) else 0.0
            return middle + 0.5 * robot_length_m
        if self.start.run is None:
            return self.start.at
        return self.route().arc_in(self.start.run, self.start.at)


def _stretches(pipe: Pipe, route: Route) -> Iterator[FrictionStretch]:
    """Yield the patches and the segments with friction of their own, in arc lengths of a route."""
    for name, (run, _, _) in pipe.written.items():
        if not any(piece.run == name for piece in route.pieces):
            continue
        own = [(each.from_m, each.to, each) for each in run.patches]
        at = 0.0
        for segment in run.segments:
            length_m = getattr(segment.in_space(), "length_m", 0.0)
            friction = getattr(segment, "friction", None)
            if friction is not None:
                own.append((at, at + length_m, friction))
            at += length_m
        for from_m, to_m, friction in own:
            one, other = sorted((route.arc_in(name, from_m), route.arc_in(name, to_m)))
            yield FrictionStretch(one, other, friction)


class PipeFile(Pipe):
    """A pipe in a file of its own; inside a mission the mission's format holds for it.

    Attributes:
        format: Version of this format.
    """

    format: Format
