"""The runs of a pipe, also those that a list of segments with tees in it stands for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, NamedTuple, TypeAlias

from pydantic import Field, StringConstraints

from pirate_sm.core._model.base import Frozen
from pirate_sm.core._model.pipe_segments import (
    InlineTee,
    Reducer,
    Roll,
    Segment,
    SegmentOrTee,
    Straight,
    TeeAngle,
)
from pirate_sm.core._model.quantities import Length
from pirate_sm.core._model.simulation import Coefficients

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
    to: Annotated[Length, Field(gt=0)]


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
