"""Write a map as a pipe file; comments name what is unknown."""

from __future__ import annotations

from collections.abc import Iterator
from math import acos, asin, atan2, cos, degrees, inf, isnan, pi, radians, remainder, sin
from typing import NamedTuple

from pirate_sm.core.geometry import dot
from pirate_sm.lab.mapping.legs import (
    LEAST_ACROSS,
    STEP,
    Leg,
    Map,
    MappedBend,
    diameter_of,
    narrowings,
)

_IN_PLANE_RAD = radians(3)
"""Bends whose planes differ by less lie in one plane [decided]."""

_LEAST_STRAIGHT_M = 0.001

_ROUNDED_M = 0.0005
"""The least distance of the start from the end: each length is rounded, and their sum counts."""


class _Segment(NamedTuple):
    text: str
    comment: str = ""
    length_m: float = 0.0


def pipe_text(made: Map, name: str, source: str, first_wheel_m: float | None = None) -> str:
    """Return a pipe file.

    Args:
        made: The map.
        name: Name of the pipe.
        source: What it was mapped from.
        first_wheel_m: Where the first wheel stood at the start, from the beginning of the pipe; by
            default the pipe begins at the last wheel.

    Returns:
        A file of one run between bars if all bends lie in the robot's plane and the diameter stays,
        else of a round pipe.
    """
    legs, flat = made.legs, _is_flat(made)
    diameter_m = next((it for it in map(diameter_of, (leg.bores for leg in legs)) if it), None)
    start_leg, start_m = made.start
    into_m = start_m - legs[start_leg].from_m + sum(_length_m(leg) for leg in legs[:start_leg])
    into_m += sum(bend.radius_m * bend.angle_rad for bend in made.bends[:start_leg])
    longer_m = 0.0 if first_wheel_m is None else first_wheel_m - into_m
    lines = [
        f"# Mapped from {source}, by the robot's signals and words alone.",
        *(f"# {note}" for note in _notes(made, longer_m)),
        "format: 1",
        f"pipe: {name}",
        *([f"diameter: {_mm(diameter_m)}"] if diameter_m else []),
        *_attitude(made, flat),
        "segments:",
    ]
    end_m = 0.0
    for segment in _segments(made, flat, longer_m):
        end_m += segment.length_m
        if segment.comment:
            lines.append(f"  # {segment.comment}")
        lines.append(f"  - {segment.text}")
    lines.append(f"start: {{at: {_mm(min(into_m + longer_m, end_m - _ROUNDED_M))}}}")
    return "\n".join(lines) + "\n"


def _notes(made: Map, longer_m: float) -> Iterator[str]:
    """Yield what holds for the whole file."""
    if longer_m == 0.0:
        yield "It begins where the robot's last wheel was; what is behind is not known."
    yield "It ends where the robot's first wheel was; what is ahead is not known."
    yield "Tees that were passed straight on, and blockages, are not in it."
    if _is_flat(made):
        yield "All bends lie in one plane: round or between bars, the signals do not say which."
    if isnan(made.pitch_rad):
        yield "How it lies against gravity is not known."
    yield from (f"A person says: {each}." for each in made.seen)
    yield from (f"Incomplete: {note}." for note in made.notes)


def _attitude(made: Map, flat: bool) -> Iterator[str]:
    """Yield how the first segment lies against gravity."""
    frame = made.frame(0)
    axes = (frame.ahead, frame.side, frame.normal)
    along, side, normal = (max(-1.0, min(1.0, dot(axis, made.up))) for axis in axes)
    if not flat:
        yield "section: round"
    if isnan(made.pitch_rad):
        return
    if flat:
        tilt_rad = min(acos(-normal), pi / 2)
        yield f"tilt: {_deg(tilt_rad)}"
        if degrees(tilt_rad) >= 0.5:
            yield f"uphill: {_deg(atan2(side, along))}"
        return
    pitch_rad = asin(along)
    roll_rad = atan2(side, -normal) if cos(pitch_rad) > LEAST_ACROSS else 0.0
    yield f"frame: {{pitch: {_deg(pitch_rad)}, roll: {_deg(roll_rad)}}}"


def _segments(made: Map, flat: bool, longer_m: float) -> Iterator[_Segment]:
    """Yield the segments of all legs, and the bends between them."""
    diameter_m: float | None = None
    for number, leg in enumerate(made.legs):
        begin_m = leg.from_m - (longer_m if number == 0 else 0.0)
        own_m = diameter_of(leg.bores)
        if own_m and diameter_m and abs(own_m - diameter_m) > STEP * diameter_m:
            at_m = max(min(each.rear_m for each in leg.bores), leg.from_m + diameter_m)
            yield _straight(at_m - begin_m)
            reducer = f"{{reducer: 0 mm, to: {_mm(own_m)}}}"
            yield _Segment(reducer, "Its place and length are not known: it is near the bend.")
            begin_m = at_m
        diameter_m = own_m or diameter_m
        for change in narrowings(leg.bores):
            yield _straight(change.middle_m - begin_m)
            reducer = f"{{reducer: 0 mm, to: {_mm(change.diameter_m)}}}"
            yield _Segment(reducer, "This is its middle; its length is not known.")
            begin_m, diameter_m = change.middle_m, change.diameter_m
        yield _straight(leg.to_m - begin_m)
        if number < len(made.bends):
            yield _bend(made.bends[number], flat)


def _bend(bend: MappedBend, flat: bool) -> _Segment:
    roll_rad = remainder(bend.roll_rad, 2 * pi)
    if bend.kind == "tee":
        text = f"{{tee: 90 deg, roll: {_deg(roll_rad)}, take: branch}}"
        return _Segment(text, "The length of the arm straight on is not known.")
    if bend.radius_m:
        radius, roll = _mm(bend.radius_m), _deg(roll_rad)
        text = f"{{elbow: {_deg(bend.angle_rad)}, radius: {radius}, roll: {roll}}}"
        sure = "Its angle is from gravity" if bend.felt else "Its angle is known to 15 deg only"
        comment = f"{sure}, its radius from words, to some centimetres."
        return _Segment(text, comment, bend.radius_m * bend.angle_rad)
    comment = "A mitre or an elbow: the signals do not say which."
    if bend.kind == "elbow":
        comment = "An elbow; its radius is not known."
    elif bend.kind == "mitre":
        comment = ""
    elif not isnan(bend.extent_m):
        comment = "A mitre, a short elbow or a tee's branch: the signals do not say which."
    if flat:
        sign = 1.0 if abs(roll_rad) < pi / 2 else -1.0
        return _Segment(f"{{mitre: {_deg(sign * bend.angle_rad)}}}", comment)
    return _Segment(f"{{mitre: {_deg(bend.angle_rad)}, roll: {_deg(roll_rad)}}}", comment)


def _is_flat(made: Map) -> bool:
    """Return whether all bends lie in the robot's plane, and nothing needs a round pipe."""
    turns = (abs(remainder(bend.roll_rad, pi)) for bend in made.bends)
    round_alone = any(bend.kind == "tee" or bend.radius_m for bend in made.bends)
    if round_alone or any(turn > _IN_PLANE_RAD for turn in turns):
        return False
    if -dot(made.frame(0).normal, made.up) < -sin(_IN_PLANE_RAD):  # the robot lies on its back
        return False
    shown = [it for it in (diameter_of(leg.bores) for leg in made.legs) if it]
    if shown and max(shown) - min(shown) > STEP * max(shown):
        return False
    return not any(any(True for _ in narrowings(leg.bores)) for leg in made.legs)


def _straight(length_m: float) -> _Segment:
    length_m = max(length_m, _LEAST_STRAIGHT_M)
    return _Segment(f"{{straight: {_mm(length_m)}}}", length_m=length_m)


def _length_m(leg: Leg) -> float:
    return leg.to_m - leg.from_m if leg.to_m < inf else 0.0


def _mm(length_m: float) -> str:
    return f"{length_m * 1e3:.1f} mm"


def _deg(angle_rad: float) -> str:
    return f"{degrees(angle_rad):z.1f} deg"
