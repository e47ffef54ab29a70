"""The contents of a report as plain values, without engine, recording or HTML.

Coordinates of pictures in space are m: x is level, ahead in the first run as seen from above; y is
on its left; z is up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

from pirate_sm.core.effects import MarkKind, SpanKind
from pirate_sm.core.geometry import Place, Vector
from pirate_sm.running.recording.viewers.pipe_walls import Outline, Rings
from pirate_sm.running.runtime.phase_times import PhaseStay
from pirate_sm.views.drawing.pipe_views import NamedPoint, SideSeen, WayPoint

if TYPE_CHECKING:
    from pirate_sm.views.report.compared_report import SecondRun

# --- pictures in space --------------------------------------------------------------------------


class FlatView(NamedTuple):
    """The robot in its pipe as it is seen along one axis.

    Attributes:
        name: What is seen, as ``From above``; empty for the plane of a planar pipe.
        poses: The position of each wheel, front to rear, at each time.
        walls: Corners of the two walls of a planar pipe.
        outlines: Convex areas that together are the inside of the pipes.
    """

    name: str
    poses: Sequence[Sequence[Place]]
    walls: tuple[tuple[Place, ...], ...] = ()
    outlines: tuple[Outline, ...] = ()


@dataclass(frozen=True)
class SpaceScene:
    """The robot in a network of round pipes.

    Attributes:
        poses: At each time the position of each wheel, front to rear.
        normals: At each time the unit normals of the planes of the front and of the rear part.
        rear: Index of the first wheel behind the roll joint.
        wheel_width_m: Width of a wheel.
        walls: The walls of all pipes.
        sides: From where the network is drawn.
        way: The centre line of the route.
        names: Joints and ends.
    """

    poses: Sequence[Sequence[Vector]]
    normals: Sequence[tuple[Vector, Vector]]
    rear: int
    wheel_width_m: float
    walls: tuple[Rings, ...]
    sides: tuple[SideSeen, ...]
    way: tuple[WayPoint, ...]
    names: tuple[NamedPoint, ...]

    @property
    def views(self) -> tuple[FlatView, ...]:
        """Return what is seen from each side."""
        return tuple(
            FlatView(
                name,
                [[(point[one], point[other]) for point in pose] for pose in self.poses],
                outlines=outlines,
            )
            for name, (one, other), outlines in self.sides
        )


# --- the report ---------------------------------------------------------------------------------


class Span(NamedTuple):
    """An interval on the timeline.

    Attributes:
        about: Details, shown on hovering.
    """

    start_s: float
    end_s: float
    text: str
    kind: SpanKind
    about: str = ""


class TimelineMark(NamedTuple):
    """An event on the timeline."""

    at_s: float
    text: str
    kind: MarkKind
    about: str = ""


class ExpectedEnd(NamedTuple):
    """When earlier runs let expect that a span ends."""

    from_s: float
    until_s: float
    about: str


@dataclass(frozen=True)
class Lane:
    """One row of the timeline; its ``spans`` do not overlap."""

    name: str
    spans: tuple[Span, ...] = ()
    marks: tuple[TimelineMark, ...] = ()
    expected: tuple[ExpectedEnd, ...] = ()


class CurveBand(NamedTuple):
    """Where the curve of a run like earlier ones is expected, from each time until the next.

    Attributes:
        low: The lower bound in the unit of the chart, NaN if there is none; ``high`` likewise.
    """

    times_s: list[float]
    low: list[float]
    high: list[float]


@dataclass(frozen=True)
class Series:
    """One curve.

    Attributes:
        times_s: Time of each value, ascending.
        values: Values in the unit of the chart; NaN if unknown.
        stepped: Whether a value holds until the next one.
        main: Whether it is emphasized.
        like: Number of the curve of the chart that this one is to be compared with; None: of none.
        band: Where earlier runs let expect it; None if they do not say.
    """

    name: str
    times_s: Sequence[float]
    values: Sequence[float]
    stepped: bool = False
    main: bool = False
    like: int | None = None
    band: CurveBand | None = None


@dataclass(frozen=True)
class Chart:
    """One plot.

    Attributes:
        digits: Number of significant decimals in this unit.
        note: A note that the reader needs.
        bands: What the bands of its curves are, in words; empty without any.
    """

    title: str
    unit: str
    digits: int
    series: tuple[Series, ...]
    note: str = ""
    bands: str = ""


@dataclass(frozen=True)
class DrawnWheel:
    """A wheel as it is drawn.

    Attributes:
        part: The part that it belongs to.
        angle: Its angle over time, rad; counter-clockwise is positive where side A is up.
        drive: Its setpoint, forward positive.
    """

    name: str
    part: str
    angle: Series
    drive: Series


@dataclass(frozen=True)
class Light:
    """A light; ``at`` is its position along the chain, 0 at the first wheel, 1 at the last."""

    name: str
    at: float
    level: Series


@dataclass(frozen=True)
class RobotScene:
    """The robot in its pipe, to scale, in the plane of the pipe, m.

    Attributes:
        source: ``truth``: a simulator knew the position. ``reckoned``: it is estimated from the
            joints and the odometer.
        times_s: Time of each pose; ``poses`` has the position of each wheel, front to rear.
        walls: Corners of each wall; empty without a pipe.
        parts: When each part held, confirmed or not.
        space: The same in space, in a network of round pipes; None between bars or if unknown.
    """

    source: Literal["truth", "reckoned"]
    times_s: Sequence[float]
    poses: Sequence[Sequence[Place]]
    walls: tuple[tuple[Place, ...], ...]
    wheels: tuple[DrawnWheel, ...]
    wheel_radius_m: float
    half_thickness_m: float
    parts: tuple[Lane, ...]
    lights: tuple[Light, ...]
    space: SpaceScene | None = None

    @property
    def views(self) -> tuple[FlatView, ...]:
        """Return the pictures in a plane."""
        return self.space.views if self.space else (FlatView("", self.poses, self.walls),)


_BEFORE_S = 0.002
"""Less than the time between two turns of a robot's bus, more than the page rounds to."""


class Sentence(NamedTuple):
    """A sentence of the story, with its time.

    Attributes:
        kind: The kind of event, for a sign next to it.
        topic: The phase that it is about; empty if it is about something else.
    """

    at_s: float
    text: str
    kind: Literal["phase", "trouble", "person", "end"] = "phase"
    topic: str = ""

    @property
    def before_s(self) -> float:
        """Return the time just before: a failure may have stopped the robot immediately."""
        return max(0.0, self.at_s - _BEFORE_S)


class PhaseLines(NamedTuple):
    """The lines of the mission's file that describe a phase or an end.

    Attributes:
        line: Number of the first one.
        text: The lines.
    """

    line: int
    text: str


class Stepping(NamedTuple):
    """How to step through a run, in lines of the mission's own file.

    Attributes:
        lines: Those before which it can pause.
        begun: When a command, wait, question, phase or end began, and its line; 0 is in the file of
            a called mission.
        breakpoints: From when on there were breakpoints before which lines.
    """

    lines: tuple[int, ...] = ()
    begun: tuple[tuple[float, int], ...] = ()
    breakpoints: tuple[tuple[float, tuple[int, ...]], ...] = ()


NO_STEPS = Stepping()


class Fact(NamedTuple):
    """A line of the details at the end of the page."""

    name: str
    text: str


class Photo(NamedTuple):
    """A picture of the camera over the setup.

    Attributes:
        at_s: When the word began.
        word: The detector's word.
        jpeg: The picture, in base 64.
    """

    at_s: float
    word: str
    jpeg: str


Outcome: TypeAlias = Literal["succeeded", "failed", "interrupted", "fault", "unfinished", "running"]


@dataclass(frozen=True)
class Report:
    """Everything that a page shows.

    Attributes:
        outcome: How the run ended; ``unfinished`` if the recording does not contain the end,
            ``running`` while more is recorded.
        summary: A summary in a few sentences.
        warnings: Warnings that the reader must know first.
        duration_s: Time of the last event.
        failures: Why the run failed, and in which phase; the last one did, earlier ones led to it.
        diagram: The mission as an SVG element, with the path taken; empty without one.
        files: Hash of each file by its name.
        recording: Hash of the recording; empty without one.
        photos: What the camera saw when words of the detector began.
        gaps: From when until when nothing is known, as the recording was damaged there.
        doubts: What a reader should look at though it was no failure: waits that were over as they
            began, and what nearly went wrong.
        other: The second run, in a report of two; everything else has both, or is of the first.
        source: Name of the mission's file; ``lines`` are those of each phase and end in it.
        passages: The phases that the run has entered, in order.
        stepping: When lines of it began.
    """

    title: str
    outcome: Outcome
    summary: tuple[str, ...]
    story: tuple[Sentence, ...]
    warnings: tuple[str, ...]
    duration_s: float
    lanes: tuple[Lane, ...]
    charts: tuple[Chart, ...]
    scene: RobotScene | None
    diagram: str
    facts: tuple[Fact, ...]
    files: Mapping[str, str]
    failures: tuple[Sentence, ...] = ()
    recording: str = ""
    photos: tuple[Photo, ...] = ()
    gaps: tuple[tuple[float, float], ...] = ()
    doubts: tuple[Sentence, ...] = ()
    other: SecondRun | None = None
    source: str = ""
    lines: Mapping[str, PhaseLines] = field(default_factory=dict)
    passages: tuple[PhaseStay, ...] = ()
    stepping: Stepping = NO_STEPS

    @property
    def failure(self) -> Sentence | None:
        """Return what made the run fail in the end; None if nothing did."""
        return self.failures[-1] if self.failures else None

    @property
    def opens_at_s(self) -> float:
        """Return the time shown first: just before a failure, else the end."""
        return self.duration_s if self.failure is None else self.failure.before_s
