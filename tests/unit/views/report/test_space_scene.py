"""A network of round pipes in the report: from above, from the side, and in space."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from math import dist

import pytest

from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.contents import Report, SpaceScene
from pirate_sm.views.report.film_strip import strip
from pirate_sm.views.report.recording_report import report_of
from pirate_sm.views.report.report_page import html, plot_script, report_json, three_script

from .conftest import ROOT, recorded


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Report:
    """Gives the report of a robot that drives into the first bend of a network."""
    pipe = ROOT / "tests" / "pipes" / "house.yaml"
    run = recorded(tmp_path_factory.mktemp("house"), "run", "mitre_bend", "--pipe", str(pipe))
    return report_of(read_recording(run))


@pytest.fixture
def space(house: Report) -> SpaceScene:
    assert house.scene is not None
    assert house.scene.space is not None
    return house.scene.space


def test_the_robot_stands_on_the_floor_and_keeps_its_size(space: SpaceScene) -> None:
    assert [z for _, _, z in space.poses[0]] == pytest.approx([-0.036] * 6, abs=1e-3)
    first = space.poses[0]
    for pose in space.poses:
        for number in range(len(pose) - 1):
            now, then = (dist(each[number], each[number + 1]) for each in (pose, first))
            assert now == pytest.approx(then, abs=2e-3)


def test_the_axles_of_a_part_are_square_to_the_link_between_the_parts(space: SpaceScene) -> None:
    for pose, normals in zip(space.poses, space.normals, strict=True):
        link = [a - b for a, b in zip(pose[space.rear - 1], pose[space.rear], strict=True)]
        for normal in normals:
            assert sum(a * b for a, b in zip(link, normal, strict=True)) == pytest.approx(0.0)
            assert sum(value**2 for value in normal) == pytest.approx(1.0)


def test_a_network_is_seen_from_above_and_from_the_side(space: SpaceScene) -> None:
    above, side = space.views
    assert (above.name, side.name) == ("From above", "From the side")
    for view, axes in ((above, (0, 1)), (side, (0, 2))):
        for pose, points in zip(space.poses, view.poses, strict=True):
            assert points == [tuple(point[axis] for axis in axes) for point in pose]
    # The way turns right, then goes up.
    xs, ys = zip(*(corner for outline in above.outlines for corner in outline), strict=True)
    assert min(ys) < -1.0
    assert max(xs) == pytest.approx(1.26, abs=0.02)
    assert max(y for outline in side.outlines for _, y in outline) > 0.6


def test_joints_and_ends_have_names_in_order(space: SpaceScene) -> None:
    names = [name for name, _ in space.names]
    assert names == ["begins", "mitre 90°", "elbow 90°", "reducer", "tee_1", "ends"]


def test_how_far_the_robot_came_is_measured_along_the_way(house: Report) -> None:
    distance = next(chart for chart in house.charts if chart.title == "Distance")
    really = next(each for each in distance.series if each.name == "really")
    assert really.values[-1] > 0.1


def test_the_strip_has_each_moment_from_both_sides_and_the_pipes_once(house: Report) -> None:
    written = strip(house)
    assert written.count("<li") * 2 == written.count("<use ")
    assert {written.count(f'id="pipes-{number}"') for number in (0, 1)} == {1}


def test_the_page_has_the_walls_and_a_canvas_for_each_view(house: Report) -> None:
    scene = report_json(house)["scene"]
    wheels = len(scene["wheels"])
    assert len(scene["paths"]) == 3 * wheels
    for wall in scene["space"]["walls"]:
        assert len(wall["mm"]) % (3 * wall["around"]) == 0
    page = html(house)
    assert re.findall(r'<canvas id="([^"]+)"', page) == ["scene", "scene-side", "space"]
    json.dumps(scene, allow_nan=False)


def test_a_planar_run_has_one_view_in_its_plane(report: Callable[[str], Report]) -> None:
    scene = report("bend").scene
    assert scene is not None
    assert scene.space is None
    (view,) = scene.views
    assert (view.walls, view.poses, view.outlines) == (scene.walls, scene.poses, ())
    assert "<use" not in strip(report("bend"))
    page = html(report("bend"))
    assert re.findall(r'<canvas id="([^"]+)"', page) == ["scene"]
    assert "THREE" not in page


def test_the_library_comes_with_its_licence_and_asks_for_no_address() -> None:
    script = three_script()
    assert "Permission is hereby granted, free of charge" in script
    assert re.findall(r"\b(?:import|export)\b[ {(*]", script) == []
    # What looks like one names the language of elements that it makes.
    assert set(re.findall(r"https?://[^'\"`\s]*", script)) == {"http://www.w3.org/1999/xhtml"}
    assert "WebGLRenderer:" in script


def test_the_plotting_library_is_a_classic_script_with_its_licence() -> None:
    script = plot_script()
    assert "Permission is hereby granted, free of charge" in script
    assert "var uPlot=" in script
    assert re.findall(r"\b(?:import|export)\b[ {(*]", script) == []
