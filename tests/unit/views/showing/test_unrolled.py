"""A robot in a round pipe, on its unrolled route with a dial for each part."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from io import StringIO
from math import pi
from pathlib import Path

import pytest
from rich.console import Console
from rich.theme import Theme

from pirate_sm.core.events import Truth
from pirate_sm.core.geometry import drawn_walls
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.views.showing import panels
from pirate_sm.views.showing.picture import ON_A_TERMINAL, Dial, RobotPose, arrow, draw, pose_of
from pirate_sm.views.showing.snapshot import Memory, Snapshot, Trends, scene_of, snapshot_of

ROOT = Path(__file__).parents[4]
HOUSE = str(ROOT / "tests" / "pipes" / "house.yaml")
RADIUS = 0.024
BORE = 0.06 - RADIUS


def beginning(pipe: str = HOUSE) -> Snapshot:
    """The moment when a mission begins in this pipe."""
    prepared = prepare(Order("mitre_bend", backend="trace", pipe=pipe))
    scene = scene_of(prepared)
    state, effects = prepared.engine.start(0.0, prepared.backend.open())
    memory = Memory(scene.robot)
    memory.see(effects, 0.0)
    return snapshot_of(scene, prepared, state, 0.0, memory.story, Trends())


@pytest.fixture(scope="module")
def still() -> Snapshot:
    return beginning()


def placed(still: Snapshot, begins_m: float, roll_rad: float = 0.0) -> Snapshot:
    """The robot clamped along its way: each wheel at the other wall, with this roll."""
    route = still.scene.route
    assert route is not None
    points = []
    for number in range(6):
        frame = route.frame_at(begins_m - 0.08 * number).rolled(roll_rad)
        points.append(frame.point(0.0, BORE if number % 2 else -BORE))
    truth = Truth(
        wheels=tuple((x, y) for x, y, _ in points),
        wheel_radius_m=RADIUS,
        walls=(),
        distance_m=0.0,
        touching=(True,) * 6,
        rolls_rad=(0.0, roll_rad, roll_rad),
        z_m=tuple(z for _, _, z in points),
    )
    return replace(still, truth=truth)


def pose(snapshot: Snapshot) -> RobotPose:
    return pose_of(snapshot)


@pytest.mark.parametrize("begins_m", [0.9, 1.9, 3.0])
@pytest.mark.parametrize("roll_rad", [0.0, 1.0, -pi / 2])
def test_a_clamped_robot_looks_alike_in_every_leg_and_with_every_roll(
    still: Snapshot, begins_m: float, roll_rad: float
) -> None:
    found = pose(placed(still, begins_m, roll_rad))
    for number, (x, y) in enumerate(found.wheels):
        assert x == pytest.approx(begins_m - 0.08 * number)
        assert y == pytest.approx(BORE if number % 2 else -BORE)
    assert found.touching == (1, 0, 1, 0, 1, 0)


def test_a_wheel_on_the_floor_of_a_robot_that_lies_touches_beside_its_plane(
    still: Snapshot,
) -> None:
    # Clamped in the upright plane, and seen as if it were rolled by a quarter turn.
    upright = placed(still, 0.9, pi / 2)
    assert upright.truth is not None
    lying = replace(upright, truth=replace(upright.truth, rolls_rad=(0.0, 0.0, 0.0)))
    found = pose(lying)
    assert found.touching == (2,) * 6
    assert [y for _, y in found.wheels] == pytest.approx([0.0] * 6, abs=1e-9)
    text = "".join(str(line) for line in panels.states(lying, 200))
    assert "1~ 2~" in text


def test_dials_show_where_side_a_points_in_either_leg(still: Snapshot) -> None:
    flat = pose(placed(still, 0.9, pi / 2)).dials
    assert [dial.text for dial in flat] == ["front A ↑ 90°", "rear A ↑ 90°"]
    right = pose(placed(still, 0.9)).dials
    assert [dial.text for dial in right] == ["front A → 0°", "rear A → 0°"]


@pytest.mark.parametrize(
    ("angle_rad", "sign"), [(0.0, "→"), (pi / 4, "↗"), (-pi / 2, "↓"), (pi, "←"), (2 * pi, "→")]
)
def test_an_arrow_is_the_nearest_of_eight(angle_rad: float, sign: str) -> None:
    assert arrow(angle_rad) == sign
    assert sign in Dial("front", angle_rad).text


def test_joints_say_what_they_are_and_where_they_lead(still: Snapshot) -> None:
    marks = pose(placed(still, 0.9)).joints
    assert [mark.text.split()[0] for mark in marks] == ["mitre", "elbow", "reducer", "tee"]
    mitre, elbow = marks[:2]
    assert (mitre.text, elbow.text) == ("mitre →", "elbow ↑")
    assert (mitre.from_m, mitre.at, mitre.to_m) == pytest.approx((1.14, 1.2, 1.26))


def test_a_robot_that_has_left_its_route_is_said_to_have(still: Snapshot) -> None:
    on = placed(still, 0.9)
    assert pose(on).place == "main, 0.90 m"
    assert on.truth is not None
    away = replace(on.truth, z_m=tuple(z - 0.5 for z in on.truth.z_m))
    assert pose(replace(on, truth=away)).place == "not on its route"


def test_the_picture_has_walls_joints_and_dials(still: Snapshot) -> None:
    rows = [line.plain for line in draw(placed(still, 1.1), 120, 30).rows()]
    text = "\n".join(rows)
    assert "mitre →" in text
    assert rows[0].rstrip().endswith("front A → 0°")
    assert rows[1].rstrip().endswith("rear A → 0°")
    assert {"A", "B"} <= set(text)
    assert rows[-1].rstrip().endswith("main, 1.10 m")
    for number in "123456":
        assert number in text


def test_the_picture_is_as_in_the_documents(still: Snapshot) -> None:
    file = ROOT / "docs" / "pictures" / "unrolled.svg"
    screen = Console(width=100, record=True, file=StringIO(), theme=Theme(dict(ON_A_TERMINAL)))
    for row in draw(placed(still, 1.16, 0.8), 100, 18).rows():
        screen.print(row)
    svg = screen.export_svg(title="a round pipe, unrolled", unique_id="unrolled")
    found = re.sub(r"\s*@font-face \{.*?\}", "", svg, flags=re.DOTALL)
    found = found.replace("Fira Code", "monospace")
    if os.environ.get("GOLDEN") == "write":
        file.write_text(found, encoding="utf-8")

    assert file.exists(), "there is no picture yet: make golden"
    assert found == file.read_text("utf-8")


def test_a_small_picture_has_the_dials_in_words_only(still: Snapshot) -> None:
    rows = [line.plain for line in draw(placed(still, 1.1), 50, 8).rows()]
    assert rows[0].rstrip().endswith("front A → 0°")


def test_without_a_third_coordinate_nothing_is_unrolled(still: Snapshot) -> None:
    snapshot = placed(still, 0.9)
    assert snapshot.truth is not None
    found = pose(replace(snapshot, truth=replace(snapshot.truth, z_m=())))
    assert found.dials == ()
    # Nor is it drawn at a place that was reckoned in a plane: the pipe does not lie in one.
    assert found.origin.startswith("drawn")


def test_between_bars_nothing_is_unrolled() -> None:
    snapshot = placed(beginning("mitre_90"), 0.5)
    assert snapshot.truth is not None
    assert snapshot.scene.route is not None
    planar = replace(snapshot.truth, walls=drawn_walls(snapshot.scene.route), z_m=())
    found = pose(replace(snapshot, truth=planar))
    assert found.wheels == planar.wheels
    assert (found.dials, found.joints) == ((), ())
