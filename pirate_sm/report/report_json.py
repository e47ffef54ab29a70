"""A report as JSON for the scripts of its page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from typing import Any, TypeAlias

from pirate_sm.report.contents import Chart, DrawnWheel, Lane, Light, Report, RobotScene, Series

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
    }
    return {**found, "clocks": clocks.written}


class _Clocks:
    """Lists of times in ms, each time as the difference from the one before."""

    def __init__(self) -> None:
        self.written: list[list[int]] = []
        self._numbers: dict[tuple[int, ...], int] = {}

    def number(self, times_s: Sequence[float]) -> int:
        """Return the number under which these times are written."""
        key = tuple(_steps([round(time * 1e3) for time in times_s]))
        if key not in self._numbers:
            self._numbers[key] = len(self.written)
            self.written.append(list(key))
        return self._numbers[key]


def _steps(values: Iterable[int]) -> Iterable[int]:
    before = 0
    for value in values:
        yield value - before
        before = value


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
    paths = [
        list(_steps([round(pose[wheel][axis] * _PLACE_PER_M) for pose in scene.poses]))
        for wheel in range(len(scene.wheels))
        for axis in (0, 1)
    ]
    return {
        "source": scene.source,
        "clock": clocks.number(scene.times_s),
        "paths": paths,
        "perMetre": _PLACE_PER_M,
        "walls": [[[round(x, 5), round(y, 5)] for x, y in wall] for wall in scene.walls],
        "radius": scene.wheel_radius_m,
        "half": scene.half_thickness_m,
        "wheels": [_wheel(each, clocks) for each in scene.wheels],
        "parts": [_lane(each) for each in scene.parts],
        "lights": [_light(each, clocks) for each in scene.lights],
    }


def _wheel(wheel: DrawnWheel, clocks: _Clocks) -> Json:
    return {
        "name": wheel.name,
        "part": wheel.part,
        "angle": _series(wheel.angle, 2, clocks),
        "drive": _series(wheel.drive, 3, clocks),
    }


def _light(light: Light, clocks: _Clocks) -> Json:
    return {"name": light.name, "at": light.at, "level": _series(light.level, 3, clocks)}
