"""Layouts for viewers of other projects, made for one robot.

A layout names topics and fields of a recording, which depend on its robot. Lichtblick and Foxglove
import JSON, with panels in a tree of splits. PlotJuggler loads XML, with tabs of plots in two
columns.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias
from xml.etree import ElementTree as Xml

from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import signals as kinds
from pirate_sm.core.palette import CURVES, EITHER
from pirate_sm.running.recording.signal_names import current_signals, signal_names, slot_names
from pirate_sm.running.recording.viewers.transforms import PIPE

Split: TypeAlias = dict[str, Any]
"""A panel is its name; a split has two panels or splits."""

_COLORS = tuple(EITHER[role] for role in CURVES)
_SCENE, _STATES, _LOG = "3D!scene", "StateTransitions!states", "RosOut!log"
_FAR_ROBOTS = 2.0
"""Height of the camera above the robot, in lengths of the robot."""


class LayoutPlot(NamedTuple):
    """A plot of numbers with one unit.

    Attributes:
        fields: Topic and field of each curve.
    """

    title: str
    fields: tuple[tuple[str, str], ...]


def plots_of(loaded: LoadedMission) -> tuple[LayoutPlot, ...]:
    """Return the plots for a robot's profile."""
    robot, profile = loaded.robot, loaded.loaded_robot.profile
    names = dict(zip(robot.vocabulary.numbers, signal_names(robot), strict=True))
    joints, rolls = profile.body.joints, [link.roll for link in profile.body.links if link.roll]
    way, speed = (
        [robot.vocabulary.numbers[index]] if index >= 0 else []
        for index in (robot.odometry, robot.speed)
    )
    diameters = [name for name, it in profile.derived.items() if isinstance(it, kinds.DiameterOf)]
    others = [
        ("Distance", way),
        ("Speed", speed),
        ("Joint angles", [*(joint.name for joint in joints), *rolls]),
        ("Joint torques", [joint.torque for joint in joints if joint.torque]),
        ("Wheel motor currents", current_signals(profile, of_wheels=True)),
        ("Joint motor currents", current_signals(profile, of_wheels=False)),
        ("Inner diameter", diameters),
    ]
    found = [
        LayoutPlot(title, tuple(("/signals", names[it]) for it in each)) for title, each in others
    ]
    drives = [
        ("/setpoints", name)
        for slot, name in zip(profile.slots, slot_names(robot), strict=True)
        if slot.unit == "duty" and (slot.joint or slot.wheel)
    ]
    found.append(LayoutPlot("Duty cycles sent to the motors", tuple(drives)))
    return tuple(plot for plot in found if plot.fields)


def lichtblick_layout(loaded: LoadedMission) -> str:
    """Return the layout for Lichtblick and Foxglove: the robot, its states, the log, and plots."""
    plots = {f"Plot!{number}": plot for number, plot in enumerate(plots_of(loaded), 1)}
    words = ("phase", "detected", *loaded.robot.regions)
    body = loaded.loaded_robot.profile.body
    panels: dict[str, Mapping[str, Any]] = {
        _SCENE: _scene(sum(link.length for link in body.links), body.links[0].module),
        _STATES: {"isSynced": True, "paths": [_path("/state", name) for name in words]},
        _LOG: {"topicToRender": "/log", "searchTerms": [], "minLogLevel": 1},
        **{name: _plot(plot) for name, plot in plots.items()},
    }
    seen = _split("column", [_SCENE, _split("column", [_STATES, _LOG])])
    half = -(-len(plots) // 2)
    columns = [_column([*plots][:half]), _column([*plots][half:])]
    layout = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split("row", [seen, _split("row", columns)]),
    }
    return json.dumps(layout, indent=1) + "\n"


def _scene(length_m: float, followed: str) -> dict[str, Any]:
    """Return the 3D panel, which looks down on the plane of the pipe and follows the robot."""
    return {
        "followTf": followed,
        "followMode": "follow-position",
        "cameraState": {
            "distance": _FAR_ROBOTS * length_m,
            "phi": 0,
            "thetaOffset": 0,
            "perspective": True,
            "target": [0, 0, 0],
            "targetOffset": [-length_m / 2, 0, 0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": 45,
            "near": 0.01,
            "far": 100,
        },
        "scene": {"transforms": {"visible": False, "showLabel": False}},
        "transforms": {f"frame:{PIPE}": {"visible": False}},
        "topics": {"/scene": {"visible": True}},
        "layers": {},
    }


def _plot(plot: LayoutPlot) -> dict[str, Any]:
    return {
        "title": plot.title,
        "foxglovePanelTitle": plot.title,
        "lichtblickPanelTitle": plot.title,
        "paths": [
            {**_path(*field), "enabled": True, "color": color}
            for field, color in zip(plot.fields, _colors(plot), strict=True)
        ],
        "isSynced": True,
        "xAxisVal": "timestamp",
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": True,
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "sidebarDimension": 240,
    }


def _path(topic: str, field: str) -> dict[str, Any]:
    return {"value": f"{topic}.{field}", "label": field, "timestampMethod": "receiveTime"}


def _colors(plot: LayoutPlot) -> Iterator[str]:
    return (_COLORS[number % len(_COLORS)] for number in range(len(plot.fields)))


def _split(direction: str, parts: Sequence[str | Split]) -> str | Split:
    """Return two parts next to or above each other; a single part alone."""
    if len(parts) < 2 or not parts[1]:
        return parts[0]
    first, second = parts
    return {"direction": direction, "first": first, "second": second, "splitPercentage": 50}


def _column(panels: Sequence[str]) -> str | Split:
    """Return panels above each other, all of one height."""
    if len(panels) < 2:
        return panels[0] if panels else ""
    share = 100 / len(panels)
    rest = _column(panels[1:])
    return {"direction": "column", "first": panels[0], "second": rest, "splitPercentage": share}


def plotjuggler_layout(loaded: LoadedMission) -> str:
    """Return the layout for PlotJuggler: one tab of signals, one of setpoints and states."""
    plots = plots_of(loaded)
    codes = [("/state", f"{region}_code") for region in loaded.robot.regions]
    states = LayoutPlot("States", tuple(codes))
    signals = [plot for plot in plots if plot.fields[0][0] == "/signals"]
    others = [plot for plot in plots if plot not in signals]
    root = Xml.Element("root")
    window = {"name": "Main Window", "parent": "main_window"}
    tabs = Xml.SubElement(root, "tabbed_widget", window)
    for title, each in (("Signals", signals), ("Setpoints and states", [*others, states])):
        half = -(-len(each) // 2)
        columns = [column for column in (each[:half], each[half:]) if column]
        tab = Xml.SubElement(tabs, "Tab", tab_name=title, containers="1")
        beside = _docks(Xml.SubElement(tab, "Container"), "|", len(columns))
        for column in columns:
            _stack(beside, column)
    Xml.SubElement(tabs, "currentTabIndex", index="0")
    Xml.SubElement(root, "use_relative_time_offset", enabled="1")
    Xml.indent(root, " ")
    return f"<?xml version='1.0' encoding='UTF-8'?>\n{Xml.tostring(root, encoding='unicode')}\n"


def _docks(parent: Xml.Element, orientation: str, count: int) -> Xml.Element:
    """Add room for parts of one size, next to (``|``) or above (``-``) each other."""
    sizes = ";".join([f"{1 / count:.6f}"] * count)
    room = {"orientation": orientation, "count": str(count), "sizes": sizes}
    return Xml.SubElement(parent, "DockSplitter", room)


def _stack(parent: Xml.Element, plots: Sequence[LayoutPlot]) -> None:
    """Add the plots above each other."""
    stack = _docks(parent, "-", len(plots))
    for plot in plots:
        area = Xml.SubElement(stack, "DockArea", name=plot.title)
        lines = Xml.SubElement(
            area, "plot", mode="TimeSeries", style="Lines", flip_x="false", flip_y="false"
        )
        Xml.SubElement(lines, "limitY")
        for (topic, field), color in zip(plot.fields, _colors(plot), strict=True):
            Xml.SubElement(lines, "curve", name=f"{topic}/{field}", color=color)
