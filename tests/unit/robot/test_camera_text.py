"""Measured values are put into a camera's file; everything else stays as it was written."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.robot.camera import CameraPose, Lens
from pirate_sm.robot.camera_file import load_camera, with_lens, with_pose

LENS = Lens(model="fisheye", f=(611.25, 612.5), centre=(970.5, 533.0), k=(-0.0125, 3e-05, 0, 0))
POSE = CameraPose(at=(0.1, -0.2, 0.55), turn=(3.0, 0.5, 0.0))
HEAD = "# mine\nformat: 1\ncamera: mine\nsource: {device: 0, size: [1920, 1080]}  # USB\n"
SETUP = """setup:  # the plate
  # measured with a steel rule
  tags: aruco_4x4_50
  size: 40 mm
  at:
    "1": [0 mm, 0 mm, 0 mm]   # the corner
    "2": [1 m, 0 mm, 0 mm]
    "3": [0 mm, 1 m, 0 mm]
    "4": [1 m, 1 m, 0 mm]
"""
TAIL = "# and the robot\nrobot: {tags: aruco_4x4_50, size: 24 mm, height: 75 mm, on: {'9': m}}\n"
OLD_LENS = "lens: {model: brown, f: [1, 1], centre: [0, 0], k: [0, 0, 0, 0, 0]}\n"
LONG_LENS = "lens:\n  model: brown\n  f: [1, 1]\n  centre: [0, 0]\n  k: [0, 0, 0, 0, 0]\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("old", ["", OLD_LENS, LONG_LENS], ids=["none", "line", "block"])
def test_the_lens_takes_the_place_of_the_old_one(tmp_path: Path, old: str) -> None:
    path = written(tmp_path, HEAD + old + SETUP + TAIL)

    new = with_lens(path, LENS)

    line = (
        "lens: {model: fisheye, f: [611.25, 612.50], centre: [970.50, 533.00],"
        " k: [-0.0125, 3e-05, 0, 0]}\n"
    )
    assert new == HEAD + line + SETUP + TAIL
    assert load_camera(written(tmp_path, new))[0].lens == LENS


@pytest.mark.parametrize(
    "old",
    [
        "",
        "  pose: {at: [0 m, 0 m, 1 m], turn: [0 deg, 0 deg, 0 deg]}\n",
        "  pose:\n    at: [0 m, 0 m, 1 m]\n    turn: [0 deg, 0 deg, 0 deg]\n",
    ],
    ids=["none", "line", "block"],
)
def test_the_pose_takes_the_place_of_the_old_one(tmp_path: Path, old: str) -> None:
    path = written(tmp_path, HEAD + SETUP + old + TAIL)

    new = with_pose(path, POSE)

    turn = "[171.887 deg, 28.648 deg, 0.000 deg]"
    line = f"  pose: {{at: [100.0 mm, -200.0 mm, 550.0 mm], turn: {turn}}}\n"
    assert sorted(new.splitlines()) == sorted((HEAD + SETUP + line + TAIL).splitlines())
    pose = load_camera(written(tmp_path, new))[0].setup.pose
    assert pose is not None
    assert pose.at == pytest.approx(POSE.at)
    assert pose.turn == pytest.approx(POSE.turn, abs=1e-4)


def test_a_setup_in_braces_is_left_to_people(tmp_path: Path) -> None:
    setup = "setup: {pose: {at: [0 m, 0 m, 1 m], turn: [0 deg, 0 deg, 0 deg]}}\n"
    path = written(tmp_path, HEAD + setup + TAIL)

    with pytest.raises(UsageError, match=r"in braces: put in by hand pose: \{at:"):
        with_pose(path, POSE)
