"""A robot in a network of round pipes, as viewers of other projects are shown it."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise
from math import cos, dist, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from recording_runs import ROOT, record_with_viewers

from pirate_sm.core._geometry.network import Elbow, Mitre, Reducer, Straight, planar
from pirate_sm.core.geometry import Route, dot
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.viewers.foxglove_scene import Cylinder, Mesh, walls_to_draw
from pirate_sm.running.recording.viewers.pipe_walls import part_normals
from pirate_sm.running.recording.viewers.transforms import Quaternion, about, of_axes
from pirate_sm.running.wiring import Order
from pirate_sm.views.console.recording_viewer import recorded_snapshots
from pirate_sm.views.showing.picture import pose_of

HOUSE = str(ROOT / "tests" / "pipes" / "house.yaml")
Floats = npt.NDArray[np.float64]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of a run in a network."""
    path: Path = tmp_path_factory.mktemp("runs") / "run.mcap"
    kept = record_with_viewers(path, Order("mitre_bend", pipe=HOUSE))
    assert kept.recording is not None
    assert kept.recording.side.failure == ""
    return path


@pytest.fixture(scope="module")
def shown(run: Path) -> dict[str, list[dict[str, Any]]]:
    """Its messages by topic."""
    found: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for each in read_recording(run).shown():
        found[each.topic].append(each.content)
    return found


def matrix(q: dict[str, float] | Quaternion) -> Floats:
    """The rotation of a quaternion."""
    x, y, z, w = q if isinstance(q, Quaternion) else (q[name] for name in "xyzw")
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def frames(transforms: list[dict[str, Any]]) -> dict[str, Floats]:
    """Where each frame is in that of the drawing, which is ``pipe``."""
    known = {"world": np.eye(4)}
    for each in transforms:
        step = np.eye(4)
        step[:3, :3] = matrix(each["rotation"])
        step[:3, 3] = [each["translation"][axis] for axis in "xyz"]
        known[each["child_frame_id"]] = known[each["parent_frame_id"]] @ step
    back = np.linalg.inv(known["pipe"])
    return {name: back @ found for name, found in known.items()}


@pytest.mark.thorough
def test_the_frames_put_every_wheel_where_it_is(shown: dict[str, list[dict[str, Any]]]) -> None:
    assert shown["/tf"]
    for message, places in zip(shown["/tf"], shown["/places"], strict=True):
        found = frames(message["transforms"])
        for number in range(1, 7):
            wheel = f"wheel_{number}"
            true = [places[f"{wheel}_{axis}_m"] for axis in "xyz"]
            assert found[wheel][:3, 3] == pytest.approx(true, abs=2e-3)


@pytest.mark.thorough
def test_the_axles_of_the_first_wheels_are_rolled_as_the_front_is(
    shown: dict[str, list[dict[str, Any]]],
) -> None:
    # In the first leg the frame of the pipe is that of the drawing.
    checked = 0
    for message, places in zip(shown["/tf"], shown["/places"], strict=True):
        if places["wheel_1_x_m"] > 1.1:
            break
        found = frames(message["transforms"])
        for wheel, part in (("wheel_3", "front"), ("wheel_4", "rear")):
            roll = places[f"{part}_roll_rad"]
            assert found[wheel][:3, 2] == pytest.approx([0.0, sin(roll), cos(roll)], abs=0.12)
        checked += 1
    assert checked > 10


@pytest.mark.thorough
def test_a_recording_is_shown_unrolled_by_the_console(
    run: Path, shown: dict[str, list[dict[str, Any]]]
) -> None:
    snapshot = recorded_snapshots(read_recording(run)).at(20.0)
    assert snapshot.truth is not None
    assert snapshot.truth.z_m in [
        tuple(each[f"wheel_{number}_z_m"] for number in range(1, 7)) for each in shown["/places"]
    ]
    pose = pose_of(snapshot)
    assert [dial.part for dial in pose.dials] == ["front", "rear"]
    assert all(0.3 < x < 1.3 and abs(y) < 0.06 for x, y in pose.wheels)


def test_down_is_down_in_the_world(shown: dict[str, list[dict[str, Any]]]) -> None:
    found = frames(shown["/tf"][0]["transforms"])
    assert (np.linalg.inv(found["world"]) @ found["wheel_1"])[2, 3] == pytest.approx(
        -0.036, abs=1e-3
    )


def test_the_scene_has_the_network_and_a_frame_for_everything(
    shown: dict[str, list[dict[str, Any]]],
) -> None:
    (scene,) = shown["/scene"]
    names = {each["child_frame_id"] for each in shown["/tf"][0]["transforms"]}
    assert {entity["frame_id"] for entity in scene["entities"]} == names
    pipe = next(each for each in scene["entities"] if each["id"] == "pipe")
    assert pipe["lines"] == []
    # The straights behind the elbow and the reducer have square ends; others are cut, and the
    # elbow, the reducer, the tee and the cap are triangles.
    assert len(pipe["cylinders"]) == 3
    assert len(pipe["triangles"]) == 7
    for mesh in pipe["triangles"]:
        assert max(mesh["indices"]) == len(mesh["points"]) - 1
        assert len(mesh["indices"]) % 3 == 0


def test_a_straight_is_a_cylinder_along_its_axis() -> None:
    route = Route(planar(0.12, (Straight(1.0), Elbow(pi / 2, 0.2), Straight(0.5)), section="round"))
    first, elbow, last = walls_to_draw(route)
    assert isinstance(first, Cylinder)
    assert isinstance(elbow, Mesh)
    assert isinstance(last, Cylinder)
    assert first.middle == pytest.approx((0.5, 0.0, 0.0))
    assert (first.diameter_m, first.length_m) == pytest.approx((0.12, 1.0))
    assert matrix(first.turned)[:, 2] == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert matrix(last.turned)[:, 2] == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("fitting", [Mitre(1.0), Reducer(0.1, 0.1), Reducer(0.0, 0.1)])
def test_the_triangles_of_a_wall_close_it_all_round(fitting: Mitre | Reducer) -> None:
    route = Route(planar(0.12, (Straight(1.0), fitting, Straight(0.5)), section="round"))
    meshes = [wall for wall in walls_to_draw(route) if isinstance(wall, Mesh)]
    assert meshes
    for mesh in meshes:
        edges: dict[tuple[int, int], int] = defaultdict(int)
        for triangle in mesh.triangles:
            for one, other in pairwise((*triangle, triangle[0])):
                edges[min(one, other), max(one, other)] += 1
        # Inside every edge has two triangles; only the two ends are open.
        around = len(mesh.points) // 2
        assert sorted(edges.values()) == [1] * 2 * around + [2] * 2 * around


@pytest.mark.parametrize("angle", [0.0, 1.0, -2.0, pi, 3.1])
def test_a_rotation_is_the_same_from_its_axes(angle: float) -> None:
    for turned in (about("x", angle), about("z", angle)):
        x, y, z = (tuple(column) for column in matrix(turned).T)
        assert matrix(of_axes(x, y, z)) == pytest.approx(matrix(turned), abs=1e-9)  # type: ignore[arg-type]
    y_turned = ((cos(angle), 0.0, -sin(angle)), (0.0, 1.0, 0.0), (sin(angle), 0.0, cos(angle)))
    assert pytest.approx(np.array(y_turned), abs=1e-9) == matrix(of_axes(*y_turned)).T


def test_the_normals_of_the_parts_are_square_to_the_link_between_them() -> None:
    route = Route(planar(0.12, (Straight(2.0),), section="round"))
    points = [(1.0 - 0.08 * n, 0.03 * (-1) ** n, 0.0) for n in range(6)]
    front, rear = part_normals(route, points, 3, (0.3, 0.0))
    ahead = tuple(a - b for a, b in zip(points[2], points[3], strict=True))
    assert dot(front, ahead) == pytest.approx(0.0)  # type: ignore[arg-type]
    assert rear == pytest.approx((0.0, 0.0, 1.0))
    assert dist(front, (0.0, 0.0, 0.0)) == pytest.approx(1.0)
