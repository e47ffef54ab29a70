"""Layouts for viewers name only what a recording has, and the shipped ones are up to date."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from mcap.reader import make_reader
from recording_runs import ROOT, record_with_viewers

from pirate_sm.core import library
from pirate_sm.core.loading import load_mission
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.viewers.layouts import lichtblick_layout, plotjuggler_layout
from pirate_sm.running.wiring import Order

RUNS = {
    "the shipped robot": Order("mitre_bend"),
    "another robot": Order(str(ROOT / "tests" / "robots" / "newt" / "patrol.yaml")),
}


@pytest.fixture(scope="module", params=RUNS)
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of a whole run, written just now."""
    path: Path = tmp_path_factory.mktemp("runs") / "run.mcap"
    record_with_viewers(path, RUNS[request.param])
    return path


@pytest.fixture(scope="module")
def layouts(run: Path) -> tuple[dict[str, Any], ElementTree.Element]:
    """The layout for Lichtblick and the one for PlotJuggler."""
    with recorded_mission(read_recording(run).header) as loaded:
        return (
            json.loads(lichtblick_layout(loaded)),
            ElementTree.fromstring(plotjuggler_layout(loaded).encode()),
        )


def shown(path: Path) -> dict[str, set[str]]:
    """The fields that some message of a topic has, by topic."""
    found: dict[str, set[str]] = {}
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            if not channel.topic.startswith("/engine/"):
                found.setdefault(channel.topic, set()).update(json.loads(message.data))
    return found


def leaves(node: Any) -> Iterator[str]:
    """The panels of a tree of splits."""
    if isinstance(node, str):
        yield node
        return
    assert node["direction"] in ("row", "column")
    assert 0 < node["splitPercentage"] < 100
    yield from leaves(node["first"])
    yield from leaves(node["second"])


def test_every_field_that_lichtblick_shall_show_is_in_the_recording(
    run: Path, layouts: tuple[dict[str, Any], ElementTree.Element]
) -> None:
    topics, panels = shown(run), layouts[0]["configById"].values()
    named = [path["value"].split(".", 1) for each in panels for path in each.get("paths", ())]

    assert len(named) > 10
    assert [each for each in named if each[1] not in topics.get(each[0], ())] == []


def test_every_topic_and_frame_that_lichtblick_shall_show_is_in_the_recording(
    run: Path, layouts: tuple[dict[str, Any], ElementTree.Element]
) -> None:
    panels = layouts[0]["configById"].values()
    topics = [topic for each in panels for topic in each.get("topics", ())]
    topics += [each["topicToRender"] for each in panels if "topicToRender" in each]
    (followed,) = (each["followTf"] for each in panels if "followTf" in each)
    first = next(iter(read_recording(run).shown("/tf"))).content["transforms"]

    assert sorted(topics) == ["/log", "/scene"]
    assert set(topics) <= shown(run).keys()
    assert followed in {each["child_frame_id"] for each in first}


def test_every_panel_of_lichtblick_has_its_place_once(
    layouts: tuple[dict[str, Any], ElementTree.Element],
) -> None:
    found = list(leaves(layouts[0]["layout"]))

    assert sorted(found) == sorted(layouts[0]["configById"])
    assert {name.partition("!")[0] for name in found} == {
        "3D", "Plot", "RosOut", "StateTransitions",
    }  # fmt: skip


def test_every_curve_of_plotjuggler_is_a_number_in_the_recording(
    run: Path, layouts: tuple[dict[str, Any], ElementTree.Element]
) -> None:
    numbers = {
        f"{each.topic}/{name}"
        for each in read_recording(run).shown("/signals", "/setpoints", "/state")
        for name, value in each.content.items()
        if isinstance(value, int | float)
    }
    curves = [curve.attrib["name"] for curve in layouts[1].iter("curve")]

    assert len(curves) > 10
    assert [name for name in curves if name not in numbers] == []


def test_plotjuggler_has_two_tabs_and_every_plot_a_curve(
    layouts: tuple[dict[str, Any], ElementTree.Element],
) -> None:
    assert len(list(layouts[1].iter("Tab"))) == 2
    assert all(plot.findall("curve") for plot in layouts[1].iter("plot"))
    for room in layouts[1].iter("DockSplitter"):
        assert room.attrib["orientation"] in "|-"
        assert int(room.attrib["count"]) == len(room) == len(room.attrib["sizes"].split(";"))


@pytest.mark.parametrize(
    ("file", "make"),
    [
        ("pirate_ii.lichtblick.json", lichtblick_layout),
        ("pirate_ii.plotjuggler.xml", plotjuggler_layout),
    ],
)
def test_the_shipped_layouts_are_those_of_the_shipped_robot(file: str, make: Any) -> None:
    loaded = load_mission(library.find_mission("mitre_bend"))

    assert (ROOT / "docs" / "viewers" / file).read_text("utf-8") == make(loaded)
