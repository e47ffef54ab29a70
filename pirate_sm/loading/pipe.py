"""Pipe files are read, and held against the reach of a robot."""

from __future__ import annotations

from math import sin
from pathlib import Path

from pirate_sm.loading.folders import shown
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.source import Document, read_document
from pirate_sm.loading.validate import validate
from pirate_sm.model.pipe import Pipe
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
    """A pipe that the robot cannot clamp is a problem, with both numbers in it."""
    least, largest = reach(profile)
    if least < pipe.diameter <= largest:
        return
    path = ("pipe", "diameter") if "pipe" in document.data and "phases" in document.data else ()
    problems.about(document).add(
        "pipe.reach",
        path or ("diameter",),
        f"{profile.robot} cannot clamp an inner diameter of {_mm(pipe.diameter)}",
        expected=f"more than {_mm(least)} and at most {_mm(largest)}: l sin(end stop / 2) + 2r",
    )


def _mm(length_m: float) -> str:
    if length_m < 1:
        return f"{length_m * 1000:.4g} mm"
    return format_quantity(length_m, LENGTH)
