"""Read pipe files, and check that a pipe can be built and that a robot can clamp in it."""

from __future__ import annotations

from itertools import pairwise
from math import degrees, pi, radians
from pathlib import Path

from pirate_sm.geometry.clamping import height_m
from pirate_sm.geometry.plane import crossing
from pirate_sm.loading.file_names import shown
from pirate_sm.loading.problems import Path as At
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.yaml.document import Document, read_document
from pirate_sm.loading.yaml.validation import validate
from pirate_sm.model.pipe import Mitre, Pipe, Straight
from pirate_sm.model.profile import Profile
from pirate_sm.units import LENGTH, format_quantity

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
    document = read_document(path, shown(path))
    return validate(document, Pipe), document


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


def check_pipe(pipe: Pipe, document: Document, problems: Problems) -> None:
    """Report why a pipe cannot be built."""
    at, about = _part_of(document), problems.about(document)
    before = len(problems.errors)
    _check_shape(pipe, at, about)
    if len(problems.errors) == before:  # otherwise the pieces have no positions
        _check_crossing(pipe, at, about)
    _check_places(pipe, at, about)


def check_fit(pipe: Pipe, profile: Profile, document: Document, problems: Problems) -> None:
    """Report why a pipe cannot be built, or why the robot cannot clamp in it."""
    check_pipe(pipe, document, problems)
    at, about = _part_of(document), problems.about(document)
    least, largest = reach(profile)
    if not least < pipe.diameter <= largest:
        about.add(
            "pipe.reach",
            (*at, "diameter"),
            f"{profile.robot} cannot clamp an inner diameter of {_mm(pipe.diameter)}",
            expected=f"more than {_mm(least)} and at most {_mm(largest)}: l sin(g / 2) + 2r with"
            f" the joint {degrees(FOLDING_ROOM_RAD):g} deg before its end stop",
        )


def _part_of(document: Document) -> At:
    """Return the path of the pipe in its document, which may be a mission."""
    return ("pipe",) if "pipe" in document.data and "phases" in document.data else ()


def _check_shape(pipe: Pipe, at: At, problems: Problems) -> None:
    """Report mitres without a straight on either side, and straights too short for their walls."""
    segments = pipe.segments
    for number in dict.fromkeys((0, len(segments) - 1)):
        if isinstance(segments[number], Mitre):
            message = "a pipe begins and ends with a straight"
            problems.add("pipe.segment", (*at, "segments", number), message)
    for number, (before, after) in enumerate(pairwise(segments), start=1):
        if isinstance(before, Mitre) and isinstance(after, Mitre):
            message = "between two mitres there is a straight"
            problems.add("pipe.segment", (*at, "segments", number), message)
    (run,) = pipe.network().runs.values()
    for number, segment in enumerate(segments):
        if isinstance(segment, Mitre) and segment.mitre == 0:
            path = (*at, "segments", number, "mitre")
            problems.add("pipe.segment", path, "a mitre turns by more than 0 deg")
        if isinstance(segment, Straight):
            least = sum(run.taken_m[max(number - 1, 0) : number + 2])
            if segment.straight <= least:
                path = (*at, "segments", number, "straight")
                message = f"the walls of its mitres meet in a straight of {_mm(segment.straight)}"
                problems.add("pipe.segment", path, message, expected=f"more than {_mm(least)}")


def _check_crossing(pipe: Pipe, at: At, problems: Problems) -> None:
    """Report pieces of the pipe that overlap."""
    found = crossing(pipe.route())
    if found is not None:
        one, two = found
        path = (*at, "segments", min(two.segment, len(pipe.segments) - 1))
        message = f"this runs into segment {one.segment + 1} of the same pipe"
        problems.add("pipe.crossing", path, message, expected="a pipe that keeps clear of itself")


def _check_places(pipe: Pipe, at: At, problems: Problems) -> None:
    """Report a start or a blockage beyond the end of the pipe."""
    length = pipe.route().length_m
    places = [((*at, "blockages", n, "at"), each.at) for n, each in enumerate(pipe.blockages)]
    if pipe.start is not None:
        places.append(((*at, "start", "at"), pipe.start.at))
    for path, place in places:
        if place > length:
            message = f"{_mm(place)} is beyond the end of the pipe"
            problems.add("pipe.place", path, message, expected=f"at most {_mm(length)}")


def _mm(length_m: float) -> str:
    if length_m < 1:
        return f"{length_m * 1000:.4g} mm"
    return format_quantity(length_m, LENGTH)
