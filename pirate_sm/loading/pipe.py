"""Pipe files are read, and held against the reach of a robot."""

from __future__ import annotations

from itertools import pairwise
from math import sin, tan
from pathlib import Path

from pirate_sm.loading.folders import shown
from pirate_sm.loading.problems import Path as At
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.source import Document, read_document
from pirate_sm.loading.validate import validate
from pirate_sm.model.pipe import Mitre, Pipe, Straight
from pirate_sm.model.profile import Profile
from pirate_sm.units import LENGTH, format_quantity


def load_pipe(path: Path) -> tuple[Pipe, Document]:
    """The pipe that a file describes, and the file.

    Raises:
        LoadError: Everything that is wrong with it.
    """
    document = read_document(path, shown(path))
    return validate(document, Pipe), document


def reach(profile: Profile) -> tuple[float, float]:
    """The least and the largest inner diameter in m that every part can clamp.

    The largest is l sin(g/2) + 2r with the apex at its end stop, or fully folded where that is
    nearer (thesis eq. 3-2); the least is where the wheels alone fill the pipe.
    """
    body = profile.body
    least = 2 * body.wheel_radius
    largest = []
    for part in body.parts.values():
        joint = next(each for each in body.joints if each.name == part.apex)
        node = next(i for i, wheel in enumerate(body.wheels) if wheel.name == joint.wheel)
        legs = [link for link in body.links[max(node - 1, 0) : node + 1] if link.roll is None]
        half = min(joint.end_stop, 3.141592653589793) / 2
        largest.append(min(leg.length for leg in legs or body.links) * sin(half) + least)
    return least, min(largest)


def check_fit(pipe: Pipe, profile: Profile, document: Document, problems: Problems) -> None:
    """A pipe that cannot be built, or that the robot cannot clamp, is a problem."""
    at: At = ("pipe",) if "pipe" in document.data and "phases" in document.data else ()
    about = problems.about(document)
    _check_shape(pipe, at, about)
    _check_places(pipe, at, about)
    least, largest = reach(profile)
    if not least < pipe.diameter <= largest:
        about.add(
            "pipe.reach",
            (*at, "diameter"),
            f"{profile.robot} cannot clamp an inner diameter of {_mm(pipe.diameter)}",
            expected=f"more than {_mm(least)} and at most {_mm(largest)}: l sin(end stop / 2) + 2r",
        )


def _check_shape(pipe: Pipe, at: At, problems: Problems) -> None:
    """Straights stand first, last and between mitres, and are long enough for their walls."""
    segments = pipe.segments
    for number in dict.fromkeys((0, len(segments) - 1)):
        if isinstance(segments[number], Mitre):
            message = "a pipe begins and ends with a straight"
            problems.add("pipe.segment", (*at, "segments", number), message)
    for number, (before, after) in enumerate(pairwise(segments), start=1):
        if isinstance(before, Mitre) and isinstance(after, Mitre):
            message = "between two mitres there is a straight"
            problems.add("pipe.segment", (*at, "segments", number), message)
    taken = [_taken(segment, pipe.diameter) for segment in segments]
    for number, segment in enumerate(segments):
        if isinstance(segment, Mitre) and segment.mitre == 0:
            path = (*at, "segments", number, "mitre")
            problems.add("pipe.segment", path, "a mitre turns by more than 0 deg")
        if isinstance(segment, Straight):
            least = sum(taken[max(number - 1, 0) : number + 2])
            if segment.straight <= least:
                path = (*at, "segments", number, "straight")
                message = f"the walls of its mitres meet in a straight of {_mm(segment.straight)}"
                problems.add("pipe.segment", path, message, expected=f"more than {_mm(least)}")


def _taken(segment: Straight | Mitre, diameter_m: float) -> float:
    """What a mitre takes of the inner wall of the straights beside it."""
    if isinstance(segment, Straight):
        return 0.0
    return diameter_m / 2 * tan(abs(segment.mitre) / 2)


def _check_places(pipe: Pipe, at: At, problems: Problems) -> None:
    length = sum(each.straight for each in pipe.segments if isinstance(each, Straight))
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
