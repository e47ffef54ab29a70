"""A report as JSON for the scripts of its page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from typing import Any, TypeAlias

from pirate_sm.views.report.contents import (
    Chart,
    DrawnWheel,
    Lane,
    Light,
    Report,
    RobotScene,
    Series,
)
from pirate_sm.views.report.space_contents import SpaceScene

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


Json: TypeAlias = dict[str, Any]

_PLACE_PER_M = 1e4
"""Positions of wheels are written in tenths of a millimetre."""


def report_json(report: Report) -> Json:
    """Return the report as JSON for the page's script; curves with equal times share them."""
    clocks = _Clocks()
    found = {
        "duration": _seconds(report.duration_s),
        "opens": _seconds(report.opens_at_s),
        "lanes": [_lane(each) for each in report.lanes],
        "charts": [_chart(each, clocks) for each in report.charts],
        "scene": _scene(report.scene, clocks) if report.scene else None,
        "gaps": [[_seconds(each) for each in gap] for gap in report.gaps],
    }
    return {**found, "clocks": clocks.written}


class _Clocks:
    """Lists of times in ms, each time as the difference from the one before."""

    def __init__(self) -> None:
        self.written: list[list[int]] = []
        self._numbers: dict[tuple[int, ...], int] = {}

    def number(self, times_s: Sequence[float]) -> int:
        """Return the number under which these times are written."""
        key = tuple(steps([round(time * 1e3) for time in times_s]))
        if key not in self._numbers:
            self._numbers[key] = len(self.written)
            self.written.append(list(key))
        return self._numbers[key]


def _chart(chart: Chart, clocks: _Clocks) -> Json:
    return {
        "title": chart.title,
        "unit": chart.unit,
        "digits": chart.digits,
        "note": chart.note,
        "series": [_series(each, chart.digits, clocks) for each in chart.series],
    }


def _series(series: Series, digits: int, clocks: _Clocks) -> Json:
    values = [_number(value, digits) for value in series.values]
    return {
        "name": series.name,
        "clock": clocks.number(series.times_s),
        "values": values,
        "stepped": series.stepped,
        "main": series.main,
    }


def _number(value: float, digits: int) -> float | int | None:
    """Return the value without insignificant decimals; unknown is null."""
    if not isfinite(value):
        return None
    rounded = round(value, digits)
    return int(rounded) if rounded == int(rounded) else rounded


def _lane(lane: Lane) -> Json:
    return {
        "name": lane.name,
        "spans": [[_seconds(s.start_s), _seconds(s.end_s), *s[2:]] for s in lane.spans],
        "marks": [[_seconds(mark.at_s), *mark[1:]] for mark in lane.marks],
    }


def _seconds(time_s: float) -> float:
    return round(time_s, 3)


def _scene(scene: RobotScene, clocks: _Clocks) -> Json:
    space = scene.space
    poses: Sequence[Sequence[Sequence[float]]] = space.poses if space else scene.poses
    found = {
        "source": scene.source,
        "clock": clocks.number(scene.times_s),
        "paths": paths_json(poses, _PLACE_PER_M),
        "perMetre": _PLACE_PER_M,
        "walls": [[rounded(corner) for corner in wall] for wall in scene.walls],
        "radius": scene.wheel_radius_m,
        "half": scene.half_thickness_m,
        "wheels": [_wheel(each, clocks) for each in scene.wheels],
        "parts": [_lane(each) for each in scene.parts],
        "lights": [_light(each, clocks) for each in scene.lights],
    }
    return found if space is None else {**found, "space": space_json(space)}


def _wheel(wheel: DrawnWheel, clocks: _Clocks) -> Json:
    return {
        "name": wheel.name,
        "part": wheel.part,
        "angle": _series(wheel.angle, 2, clocks),
        "drive": _series(wheel.drive, 3, clocks),
    }


def _light(light: Light, clocks: _Clocks) -> Json:
    return {"name": light.name, "at": light.at, "level": _series(light.level, 3, clocks)}
