"""What a control takes over from the one that it extends: grip and gravity compensation."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from pirate_sm.core._engine.robot.actuation_spec import GripSpec, Write
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._loading.robot.loader import load_robot

PIRATE = Path(__file__).resolve().parents[5] / "hardware_profiles" / "pirate_ii"
MORE = """\
controls:
  base:
    actuation:
      FrontWheelsState:
        DrivingForward: {wheel_1: 90 mm/s, wheel_2: -90 mm/s, wheel_3: 90 mm/s}
      BendingState:
        DoubleClamped: {bend_1: -350 mNm, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 350 mNm}
    gravity_compensation: true
    grip: {safety: 2, friction: {front: 0.3, rear: 0.4}, at_most: 600 mNm}
  same: {extends: base}
  harder: {extends: same, grip: {safety: 3, friction: {front: 0.5, rear: 0.5}, at_most: 500 mNm}}
  hardest: {extends: harder, gravity_compensation: false}
  overlaid:
    extends: base
    actuation:
      BendingState:
        DoubleClamped: {bend_1: -200 mNm, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 200 mNm}
"""


def with_controls(folder: Path, text: str = MORE) -> Path:
    robot = folder / "pirate_ii"
    shutil.copytree(PIRATE, robot)
    profile = robot / "profile.yaml"
    written = profile.read_text(encoding="utf-8")
    profile.write_text(written.replace("controls:\n", text, 1), encoding="utf-8")
    return robot


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> RobotSpec:
    return load_robot(with_controls(tmp_path_factory.mktemp("robots"))).normal


def writes(robot: RobotSpec, control: str, region: str, state: str) -> dict[str, Write]:
    (spec,) = (each for each in robot.controls if each.name == control)
    (stage,) = spec.actuation[robot.regions.index(region)][state]
    return {robot.slots[write.slot].name: write for write in stage}


def grips(robot: RobotSpec, control: str) -> tuple[GripSpec | None, GripSpec | None]:
    held = writes(robot, control, "BendingState", "DoubleClamped")
    return held["bend_1"].grip, held["bend_4"].grip


@pytest.mark.parametrize(
    ("control", "safety", "frictions", "at_most_nm"),
    [
        ("base", 2, (0.3, 0.4), 0.6),
        ("same", 2, (0.3, 0.4), 0.6),
        ("harder", 3, (0.5, 0.5), 0.5),
        ("hardest", 3, (0.5, 0.5), 0.5),
        ("overlaid", 2, (0.3, 0.4), 0.6),
        ("exp_3d", 2, (0.2, 0.5), 0.7 * 1.01),
    ],
)
def test_a_grip_lasts_until_a_control_names_its_own(
    robot: RobotSpec,
    control: str,
    safety: float,
    frictions: tuple[float, float],
    at_most_nm: float,
) -> None:
    front, rear = grips(robot, control)

    assert front is not None
    assert rear is not None
    assert (front.friction, rear.friction) == frictions
    assert front.safety == rear.safety == safety
    assert front.at_most_nm == pytest.approx(at_most_nm)


def test_a_torque_of_zero_and_a_control_without_a_grip_have_none(robot: RobotSpec) -> None:
    assert writes(robot, "base", "BendingState", "DoubleClamped")["bend_2"].grip is None
    assert grips(robot, "exp_3a") == (None, None)


@pytest.mark.parametrize(
    ("control", "compensates"),
    [("base", True), ("same", True), ("harder", True), ("hardest", False), ("exp_3a", False)],
)
def test_gravity_compensation_lasts_until_a_control_ends_it(
    robot: RobotSpec, control: str, compensates: bool
) -> None:
    driven = writes(robot, control, "FrontWheelsState", "DrivingForward")

    assert {write.assist_nm != 0 for write in driven.values()} == {compensates}


@pytest.mark.thorough
def test_a_fault_of_an_inherited_grip_is_told_once_where_the_grip_stands(tmp_path: Path) -> None:
    folder = with_controls(tmp_path, MORE.replace("at_most: 600 mNm", "at_most: 900 mNm"))

    with pytest.raises(LoadError) as told:
        load_robot(folder)

    about = {(each.place, each.message) for each in told.value.problems}
    assert len(told.value.problems) == len(about) == 2, "once for each apex"
    assert {place.line for place, _ in about} == {
        1
        + (folder / "profile.yaml")
        .read_text("utf-8")
        .splitlines()
        .index("    grip: {safety: 2, friction: {front: 0.3, rear: 0.4}, at_most: 900 mNm}")
    }


@pytest.mark.thorough
def test_a_profile_of_a_recording_may_name_the_limit_of_unmoved_joints_as_it_did(
    tmp_path: Path,
) -> None:
    robot = tmp_path / "pirate_ii"
    shutil.copytree(PIRATE, robot)
    profile = robot / "profile.yaml"
    before = profile.read_text("utf-8")
    profile.write_text(before.replace("unmoved_limit", "held_limit"), "utf-8")

    assert profile.read_text("utf-8") != before
    loops = [
        {slot.position for slot in load_robot(folder).normal.slots} for folder in (PIRATE, robot)
    ]
    assert loops[0] == loops[1]
    assert any(loop is not None and loop.unmoved_limit == 1.0 for loop in loops[1])
