"""The runs of a pipe, and their segments: straights, fittings, and tees, which stand for runs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Literal, NamedTuple, TypeAlias

from pydantic import AfterValidator, Field, StringConstraints, Tag

from pirate_sm.core._geometry import network as space
from pirate_sm.core._model.base import Frozen, by_key
from pirate_sm.core._model.quantities import Angle, Length, PositiveLength, range_fault
from pirate_sm.core._model.robot.simulation import Coefficients

_ROUNDING_DEG = 1e-6


def within(limit_deg: int) -> AfterValidator:
    """Return a validator of angles up to a limit in either direction."""

    def check(angle_rad: float) -> float:
        angle_deg = math.degrees(angle_rad)
        if abs(angle_deg) <= limit_deg + _ROUNDING_DEG:
            return angle_rad
        bound = f"at most {limit_deg}" if angle_deg > 0 else f"at least -{limit_deg}"
        raise range_fault(f"expected {bound} deg, got {angle_deg:.6g} deg")

    return AfterValidator(check)


def _square(angle_rad: float) -> float:
    """Return the angle of a tee; raise ValueError unless it is a right angle."""
    if abs(math.degrees(angle_rad) - 90) > _ROUNDING_DEG:
        raise range_fault(f"expected 90 deg, got {math.degrees(angle_rad):.6g} deg")
    return angle_rad


TeeAngle = Annotated[Angle, AfterValidator(_square)]
"""The angle of a tee, between its run and its branch; 90 deg."""

Roll = Annotated[Angle, within(180)]


def _mm(length_m: float) -> str:
    """Return a length in mm, or in m from 1 m on."""
    return f"{length_m:.4g} m" if length_m >= 1.0 else f"{length_m * 1e3:.4g} mm"


def _turn(angle_rad: float, roll_rad: float) -> str:
    rolled = f" rolled {math.degrees(roll_rad):.4g}°" if roll_rad else ""
    return f"{math.degrees(angle_rad):.4g}°{rolled}"


class Straight(Frozen):
    """A straight of this length, measured along the axis to the intersection of the axes.

    Attributes:
        straight: Its length, measured along the axis to the intersection of the axes.
        friction: Friction of its wall; overrides that of the pipe.
    """

    straight: Annotated[Length, Field(gt=0, le=100)]
    friction: Coefficients | None = None

    @property
    def words(self) -> str:
        """Return it in a few words."""
        return f"straight {_mm(self.straight)}"

    def in_space(self) -> space.Straight:
        """Return it as geometry."""
        return space.Straight(self.straight)


class Mitre(Frozen):
    """A mitre bend by this angle; positive turns to side A of the robot in normal polarity.

    Attributes:
        mitre: Its angle, at most 120 deg in either direction; positive turns to side A of the robot
            in normal polarity.
        roll: Roll of its plane about the direction of travel, in a round pipe: 0 deg turns towards
            side A, 90 deg turns up where the run is flat.
    """

    mitre: Annotated[Angle, within(120)]
    roll: Roll = 0.0

    @property
    def words(self) -> str:
        """Return it in a few words."""
        return f"mitre {_turn(self.mitre, self.roll)}"

    def in_space(self) -> space.Mitre:
        """Return it as geometry."""
        return space.Mitre(self.mitre, self.roll)


class Elbow(Frozen):
    """A bend by this angle along an arc, in a round pipe.

    Attributes:
        elbow: Its angle, at most 180 deg in either direction; positive turns to side A.
        radius: Radius of its centre line; at least half the diameter.
        roll: Roll of its plane about the direction of travel.
        friction: Friction of its wall; overrides that of the pipe.
    """

    elbow: Annotated[Angle, within(180)]
    radius: Annotated[Length, Field(gt=0, le=100)]
    roll: Roll = 0.0
    friction: Coefficients | None = None

    @property
    def words(self) -> str:
        """Return it in a few words."""
        return f"elbow {_turn(self.elbow, self.roll)}"

    def in_space(self) -> space.Elbow:
        """Return it as geometry."""
        return space.Elbow(self.elbow, self.radius, self.roll)


class Reducer(Frozen):
    """A cone of this length to another diameter, in a round pipe; a length of 0 is a step.

    Attributes:
        reducer: Its length.
        to: Inner diameter behind it.
        friction: Friction of its wall; overrides that of the pipe.
    """

    reducer: Annotated[Length, Field(ge=0, le=100)]
    to: Annotated[Length, Field(gt=0, le=10)]
    friction: Coefficients | None = None

    @property
    def words(self) -> str:
        """Return it in a few words."""
        return f"reducer to {_mm(self.to)}"

    def in_space(self) -> space.Reducer:
        """Return it as geometry."""
        return space.Reducer(self.reducer, self.to)


class InlineTee(Frozen):
    """A tee in a list of segments, which goes on in its branch or straight on.

    Attributes:
        tee: Angle between its run and its branch; 90 deg.
        roll: Direction of the branch about the direction of travel: 0 deg is towards side A, 90 deg
            is up where the run is flat.
        take: Which of its arms the following segments are; the other is a closed stub.
        stub: Length of the stub, from the intersection of the axes.
        diameter: Inner diameter of the branch; by default that of the run.
    """

    tee: TeeAngle
    roll: Roll = 0.0
    take: Literal["branch", "on"]
    stub: Annotated[Length, Field(gt=0, le=100)] = 0.5
    diameter: Annotated[Length, Field(gt=0, le=10)] | None = None


_Straight: TypeAlias = Annotated[Straight, Tag("straight")]
_Mitre: TypeAlias = Annotated[Mitre, Tag("mitre")]
_Elbow: TypeAlias = Annotated[Elbow, Tag("elbow")]
_Reducer: TypeAlias = Annotated[Reducer, Tag("reducer")]

Segment: TypeAlias = Annotated[
    _Straight | _Mitre | _Elbow | _Reducer,
    by_key(
        ("straight", "mitre", "elbow", "reducer"),
        custom_error_type="segment",
        custom_error_message="expected a segment, {straight: 1.0 m}, {mitre: 90 deg},"
        " {elbow: 90 deg, radius: 180 mm} or {reducer: 60 mm, to: 100 mm}",
    ),
]
"""A segment of a run."""

SegmentOrTee: TypeAlias = Annotated[
    _Straight | _Mitre | _Elbow | _Reducer | Annotated[InlineTee, Tag("tee")],
    by_key(
        ("straight", "mitre", "elbow", "reducer", "tee"),
        custom_error_type="segment",
        custom_error_message="expected a segment, {straight: 1.0 m}, {mitre: 90 deg},"
        " {elbow: 90 deg, radius: 180 mm}, {reducer: 60 mm, to: 100 mm} or"
        " {tee: 90 deg, take: branch}",
    ),
]
"""A segment of a pipe without runs."""


Port = Annotated[
    str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*(\.(on|branch))?$", max_length=71)
]
"""Where a run begins or ends: an end, a junction, or a port of a tee, ``t1``, ``t1.on`` or
``t1.branch``."""

KeyPath: TypeAlias = tuple[str | int, ...]


class Patch(Coefficients):
    """A stretch of the wall with friction of its own.

    Attributes:
        from_m: Where it begins, along the axis from the beginning of the pipe.
        to: Where it ends.
    """

    from_m: Annotated[Length, Field(alias="from", ge=0)]
    to: PositiveLength


class PipeRun(Frozen):
    """A pipe without branches, between two junctions or ends.

    Attributes:
        from_port: Where it begins.
        to: Where it ends.
        diameter: Inner diameter at its beginning; by default that of the pipe.
        segments: Straights and fittings, in order.
        patches: Stretches of its wall with friction of their own, along its axis.
    """

    from_port: Annotated[Port, Field(alias="from")]
    to: Port
    diameter: Annotated[Length, Field(gt=0, le=10)] | None = None
    segments: Annotated[tuple[Segment, ...], Field(min_length=1, max_length=100)]
    patches: tuple[Patch, ...] = ()


class Junction(Frozen):
    """A tee between runs.

    Attributes:
        tee: Angle between its run and its branch; 90 deg.
        roll: Direction of the branch about the direction from its port ``NAME`` to ``NAME.on``: 0
            deg is towards side A, 90 deg is up where the run is flat.
    """

    tee: TeeAngle
    roll: Roll = 0.0


class Written(NamedTuple):
    """A run, and where it stands in its file.

    Attributes:
        run: The run.
        at: Path of its segments' list.
        first: Number in that list of its first segment.
    """

    run: PipeRun
    at: KeyPath
    first: int = 0


class Expanded(NamedTuple):
    """A list of segments as runs.

    Attributes:
        runs: The runs by name; those of the route first.
        tees: The tees by name, as written.
        route: Names of the runs in order.
    """

    runs: dict[str, Written]
    tees: dict[str, InlineTee]
    route: tuple[str, ...]


def expanded(
    segments: Sequence[SegmentOrTee], diameter_m: float, patches: tuple[Patch, ...]
) -> Expanded:
    """Return the runs of a list of segments with tees.

    Args:
        segments: The segments.
        diameter_m: Inner diameter at the beginning.
        patches: Those of the first run, which keeps them if it is the only one.
    """
    runs: dict[str, Written] = {}
    stubs: dict[str, Written] = {}
    tees: dict[str, InlineTee] = {}
    begins, parts = "entry", list(_parts(segments))
    for number, (first, part, tee) in enumerate(parts, start=1):
        ends = "exit" if tee is None else f"tee_{number}"
        kept = patches if len(parts) == 1 else ()
        run = _run(begins, ends, diameter_m, part, kept)
        runs["main" if number == 1 else f"main_{number}"] = Written(run, ("segments",), first)
        if tee is not None:
            tees[ends] = tee
            along_m = _narrowed_m(part, diameter_m)
            widths = {"on": along_m, "branch": tee.diameter or along_m}
            other = "on" if tee.take == "branch" else "branch"
            stub = (Straight(straight=tee.stub),)
            cap = _run(f"{ends}.{other}", f"cap_{number}", widths[other], stub, ())
            stubs[f"stub_{number}"] = Written(cap, ("segments", first + len(part)), 0)
            begins, diameter_m = f"{ends}.{tee.take}", widths[tee.take]
    return Expanded({**runs, **stubs}, tees, tuple(runs))


def _parts(
    segments: Sequence[SegmentOrTee],
) -> Iterator[tuple[int, tuple[Segment, ...], InlineTee | None]]:
    """Yield the segments between the tees, each with its first number and the tee behind it."""
    part: list[Segment] = []
    first = 0
    for number, each in enumerate(segments):
        if not isinstance(each, InlineTee):
            part.append(each)
            continue
        yield first, tuple(part), each
        part, first = [], number + 1
    yield first, tuple(part), None


def _run(
    begins: str, ends: str, diameter_m: float, part: tuple[Segment, ...], patches: tuple[Patch, ...]
) -> PipeRun:
    return PipeRun.model_construct(
        from_port=begins, to=ends, diameter=diameter_m, segments=part, patches=patches
    )


def _narrowed_m(part: Sequence[Segment], diameter_m: float) -> float:
    """Return the inner diameter behind segments, m."""
    reducers = [each.to for each in part if isinstance(each, Reducer)]
    return reducers[-1] if reducers else diameter_m
