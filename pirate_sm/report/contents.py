"""The contents of a report as plain values, without engine, recording or HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.geometry.space import Place

SpanKind: TypeAlias = Literal[
    "phase", "state", "unconfirmed", "done", "failed", "open", "wait", "word", "question"
]
MarkKind: TypeAlias = Literal[
    "trigger", "fault", "error", "warning", "skipped", "refused", "operator", "end"
]


class Span(NamedTuple):
    """Something that lasted.

    Attributes:
        about: More about it, shown when it is pointed at.
    """

    start_s: float
    end_s: float
    text: str
    kind: SpanKind
    about: str = ""


class TimelineMark(NamedTuple):
    """Something that happened at one moment."""

    at_s: float
    text: str
    kind: MarkKind
    about: str = ""


@dataclass(frozen=True)
class Lane:
    """One row of the timeline; nothing in ``spans`` overlaps."""

    name: str
    spans: tuple[Span, ...] = ()
    marks: tuple[TimelineMark, ...] = ()


@dataclass(frozen=True)
class Series:
    """One curve.

    Attributes:
        times_s: When each value held; rising.
        values: In the unit of the chart; NaN where it was unknown.
        stepped: Whether a value holds until the next one.
        main: Whether it stands out among the others.
    """

    name: str
    times_s: Sequence[float]
    values: Sequence[float]
    stepped: bool = False
    main: bool = False


@dataclass(frozen=True)
class Chart:
    """One plot.

    Attributes:
        digits: Decimals that mean something in this unit.
        note: What a reader must know about it.
    """

    title: str
    unit: str
    digits: int
    series: tuple[Series, ...]
    note: str = ""


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
    """A light; ``at`` is where along the chain it is, 0 at the first wheel, 1 at the last."""

    name: str
    at: float
    level: Series


@dataclass(frozen=True)
class RobotScene:
    """The robot in its pipe, to scale, in the plane of the pipe, m.

    Attributes:
        source: ``truth``: a simulator knew where the robot was. ``reckoned``: it is taken to be
            there, from its joints and its odometer.
        times_s: When each pose held; ``poses`` has the place of each wheel then, front to rear.
        walls: Corners of each wall; none without a pipe.
        parts: When each part held, confirmed or not.
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


_BEFORE_S = 0.002
"""Less than lies between two turns of a robot's bus, more than what a page rounds to."""


class Sentence(NamedTuple):
    """A sentence of the story, and when that was.

    Attributes:
        kind: What sort of thing it tells of, for a sign beside it.
        topic: The phase that it is about; empty for a sentence about anything else.
    """

    at_s: float
    text: str
    kind: Literal["phase", "trouble", "person", "end"] = "phase"
    topic: str = ""

    @property
    def before_s(self) -> float:
        """Return the moment just before: what goes wrong may have stopped the robot at once."""
        return max(0.0, self.at_s - _BEFORE_S)


class Fact(NamedTuple):
    """A line of the small print."""

    name: str
    text: str


@dataclass(frozen=True)
class Report:
    """Everything that a page tells.

    Attributes:
        outcome: How the run ended; ``unfinished`` where the recording does not say.
        summary: What happened, in few sentences.
        warnings: What a reader must know before they believe it.
        duration_s: Until when there is something to tell.
        failures: What made it fail and in which phase: the last one did, those before led there.
        diagram: The mission as an SVG element, with the path taken; empty without one.
        files: Hash of each file by its name.
        recording: Hash of the recording that it tells of; empty without one.
    """

    title: str
    outcome: Literal["succeeded", "failed", "interrupted", "fault", "unfinished"]
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

    @property
    def failure(self) -> Sentence | None:
        """Return what made it fail in the end; None where nothing did."""
        return self.failures[-1] if self.failures else None

    @property
    def opens_at_s(self) -> float:
        """Return where a reader begins: before a failure, at a sudden end, else at the start."""
        if self.failure is not None:
            return self.failure.before_s
        return self.duration_s if self.outcome in ("interrupted", "unfinished") else 0.0
