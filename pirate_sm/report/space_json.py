"""The report's pictures in space as JSON for the scripts of its page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from pirate_sm.report.space_contents import SpaceScene

_DIRECTION = 1e4
"""Directions are written in parts of ten thousand."""

_MM = 1e3


def steps(values: Iterable[int]) -> Iterable[int]:
    """Yield each value as the difference from the one before."""
    before = 0
    for value in values:
        yield value - before
        before = value


def paths_json(poses: Sequence[Sequence[Sequence[float]]], per_unit: float) -> list[list[int]]:
    """Return each coordinate of each point over time, in whole parts of a unit, as differences."""
    if not poses:
        return []
    return [
        list(steps([round(pose[number][axis] * per_unit) for pose in poses]))
        for number, point in enumerate(poses[0])
        for axis in range(len(point))
    ]


def rounded(point: Iterable[float]) -> list[float]:
    """Return the coordinates to a hundredth of a millimetre."""
    return [round(value, 5) for value in point]


def space_json(space: SpaceScene) -> dict[str, Any]:
    """Return the scene as JSON; the wheels' paths stand beside it."""
    return {
        "normals": paths_json(space.normals, _DIRECTION),
        "perUnit": _DIRECTION,
        "rear": space.rear,
        "width": space.wheel_width_m,
        "walls": [
            {
                "around": len(rings[0]),
                "mm": [
                    round(value * _MM, 1) for ring in rings for point in ring for value in point
                ],
            }
            for rings in space.walls
        ],
        "views": [
            {
                "name": name,
                "axes": axes,
                "outlines": [[rounded(corner) for corner in outline] for outline in outlines],
            }
            for name, axes, outlines in space.sides
        ],
        "way": [[*rounded(point), diameter_m] for point, diameter_m in space.way],
        "names": [[name, *rounded(point)] for name, point in space.names],
    }
