"""Read pipe files, and check that a robot can clamp in a pipe."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, pi, radians
from pathlib import Path

from pirate_sm.core._geometry.chain import height_m
from pirate_sm.core._loading.file_kinds import FileKind, refuse_other
from pirate_sm.core._loading.pipe_shape import check_pipe, check_section, mm, part_of
from pirate_sm.core._loading.problems import Path as At
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.yaml.document import Document, read_document
from pirate_sm.core._loading.yaml.validation import try_validate
from pirate_sm.core._model.pipe import Pipe, PipeFile
from pirate_sm.core._model.pipe_segments import Reducer
from pirate_sm.core._model.profile import Profile

FOLDING_ROOM_RAD = radians(10.0)
"""Smallest distance of a V's apex joint from its end stop in a pipe that fits.

A V under load folds further than the pipe's walls require, by up to 12 deg in a stuck robot. At its
end stop a V exerts no force on the wall. Of 60 simulated bends, 60 succeeded with 8 deg left, 46
with 6 deg and none with 5 deg (docs/measurements.md).
"""


def load_pipe(path: Path) -> tuple[Pipe, Document]:
    """Return the pipe in a file, and the file's document.

    Raises:
        LoadError: The file has faults; holds all of them.
    """
    document = read_document(path)
    problems = Problems(document)
    pipe = try_validate(document, PipeFile, problems)
    if pipe is None:
        refuse_other(document, FileKind.PIPE)
        check_section(document, problems)
    problems.raise_errors()
    assert pipe is not None
    return pipe, document


def reach(profile: Profile) -> tuple[float, float]:
    """Return the smallest and the largest inner diameter that every part can clamp, m.

    The largest is l sin(g/2) + 2r with the apex ``FOLDING_ROOM_RAD`` before its end stop, or fully
    folded if that is nearer (thesis eq. 3-2). At the smallest the wheels alone fill the pipe.
    """
    body = profile.body
    least = 2 * body.wheel_radius
    stops = {joint.name: joint.end_stop for joint in body.joints}
    largest = []
    for name, part in body.parts.items():
        apex = min(max(stops[part.apex] - FOLDING_ROOM_RAD, 0.0), pi)
        largest.append(height_m(min(body.legs_m(name)), apex) + least)
    return least, min(largest)


def check_fit(pipe: Pipe, profile: Profile, document: Document, problems: Problems) -> None:
    """Report why a pipe cannot be built, or why the robot cannot clamp in it."""
    check_pipe(pipe, document, problems)
    check_reach(pipe, profile, document, problems)


def check_reach(pipe: Pipe, profile: Profile, document: Document, problems: Problems) -> None:
    """Report the inner diameters of a pipe in which the robot cannot clamp."""
    at, about = part_of(document), problems.about(document)
    least, largest = reach(profile)
    for path, diameter_m in dict(_diameters(pipe)).items():
        if not least < diameter_m <= largest:
            about.add(
                "pipe.reach",
                (*at, *path),
                f"{profile.robot} cannot clamp an inner diameter of {mm(diameter_m)}",
                expected=f"more than {mm(least)} and at most {mm(largest)}: l sin(g / 2) + 2r with"
                f" the joint {degrees(FOLDING_ROOM_RAD):g} deg before its end stop",
            )


def _diameters(pipe: Pipe) -> Iterator[tuple[At, float]]:
    """Yield the inner diameters of the pipe that routes lead through, with their paths."""
    for name in dict.fromkeys(run for way in pipe.ways.values() for run in way):
        written = pipe.written.get(name)
        if written is None:
            continue
        run, at, first = written
        behind_tee = pipe.runs is None and first > 0
        own = pipe.runs is not None and pipe.runs[name].diameter is not None
        if not behind_tee:
            yield (*at[:-1], "diameter") if own else ("diameter",), run.diameter or pipe.diameter
        elif run.diameter is not None:
            yield (*at, first - 1, "diameter"), run.diameter
        for number, segment in enumerate(run.segments):
            if isinstance(segment, Reducer):
                yield (*at, first + number, "to"), segment.to
