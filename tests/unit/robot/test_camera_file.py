"""Camera files: what they mean, and what is said of faults that the models cannot see."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core.documents import LoadError
from pirate_sm.robot.camera_file import load_camera

ROOT = Path(__file__).resolve().parents[3]
SETUP = """format: 1
camera: mine
source: {device: 0, size: [640, 480]}
setup: {points: [], tags: aruco_4x4_50, size: 40 mm, at: {
  "10": [0 mm, 0 mm, 0 mm], "11": [300 mm, 0 mm, 40 mm],
  "12": [0 mm, 300 mm, 40 mm], "13": [300 mm, 300 mm, 0 mm]}}
robot: {tags: aruco_4x4_50, size: 24 mm, height: 75 mm, on: {"0": bend_1}}
latency: 80 ms
"""


def faults(folder: Path, *swaps: tuple[str, str]) -> list[str]:
    text = SETUP
    for old, new in swaps:
        assert old in text
        text = text.replace(old, new)
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    try:
        load_camera(path)
    except LoadError as error:
        return [f"{p.place.line}:{p.place.column} {p.message}" for p in error.problems]
    return []


@pytest.mark.parametrize(
    "path", sorted((ROOT / "cameras").glob("*.yaml")), ids=lambda path: path.stem
)
def test_a_shipped_camera_loads_and_has_the_name_of_its_file(path: Path) -> None:
    camera, _ = load_camera(path)

    assert camera.camera == path.stem


def test_lengths_and_times_are_in_si_units(tmp_path: Path) -> None:
    assert faults(tmp_path) == []

    camera, _ = load_camera(tmp_path / "mine.yaml")

    assert camera.setup.at["11"] == (0.3, 0.0, 0.04)
    assert camera.latency_s == 0.08
    assert camera.source.rate == 30.0


def test_a_tag_that_its_family_does_not_have(tmp_path: Path) -> None:
    assert faults(tmp_path, ('"13"', '"50"')) == [
        "6:32 the family aruco_4x4_50 has no tag 50",
    ]


def test_a_tag_both_on_the_setup_and_on_the_robot(tmp_path: Path) -> None:
    assert faults(tmp_path, ('{"0": bend_1}', '{"10": bend_1}')) == [
        "7:62 tag 10 is on the setup, too",
    ]


def test_too_few_places_for_the_pose_unless_the_pose_is_known(tmp_path: Path) -> None:
    three = (', "13": [300 mm, 300 mm, 0 mm]', "")
    pose = ("points: [],", "pose: {at: [0 m, 0 m, 1 m], turn: [180 deg, 0 deg, 0 deg]},")

    assert faults(tmp_path, three) == [
        "4:58 3 known places are too few to find where the camera hangs"
    ]
    assert faults(tmp_path, three, pose) == []


def test_a_point_outside_of_the_picture(tmp_path: Path) -> None:
    assert faults(tmp_path, ("points: []", "points: [{at: [0 m, 0 m, 0 m], seen: [640, 3]}]")) == [
        "4:46 this is outside of the picture of 640 × 480"
    ]


def test_a_lens_with_the_coefficients_of_another_model(tmp_path: Path) -> None:
    lens = "lens: {model: brown, f: [600, 600], centre: [320, 240], k: [0, 0, 0, 0]}\nsetup:"

    assert faults(tmp_path, ("setup:", lens)) == ["4:1 `k` of a brown lens has 5 numbers, not 4"]


def test_a_place_with_two_coordinates(tmp_path: Path) -> None:
    assert faults(tmp_path, ('"10": [0 mm, 0 mm, 0 mm]', '"10": [0 mm, 0 mm]')) == [
        "5:3 the list is too short"
    ]


def test_tags_without_their_size(tmp_path: Path) -> None:
    assert faults(tmp_path, ("size: 40 mm, ", "")) == [
        "4:1 with `tags` give their `size`, and in `at` where each of them is"
    ]


POSE = '"13": [300 mm, 300 mm, 0 mm]}'


@pytest.mark.parametrize(
    ("turn", "up"),
    [
        ("[180 deg, 0 deg, 0 deg]", False),
        ("[166.3 deg, 68.9 deg, 0 deg]", False),
        ("[0 deg, 120 deg, 0 deg]", False),
        ("[90 deg, 0 deg, 0 deg]", False),  # along the plate, which a fisheye sees
        ("[0 deg, 60 deg, 0 deg]", True),
        ("[0 deg, 0 deg, 90 deg]", True),
    ],
)
def test_a_camera_looks_down(tmp_path: Path, turn: str, up: bool) -> None:
    pose = f", pose: {{at: [0 mm, 0 mm, 550 mm], turn: {turn}}}"

    found = faults(tmp_path, (POSE, POSE + pose))
    assert [each.partition(" ")[2].partition(",")[0] for each in found] == [
        "the camera looks up"
    ] * up


def test_a_pose_that_is_not_used_is_not_judged(tmp_path: Path) -> None:
    pose = ", pose: {at: [0 mm, 0 mm, 550 mm], turn: [0 deg, 0 deg, 0 deg]}"
    assert faults(tmp_path, (POSE, POSE + pose)) != []

    camera, _ = load_camera(tmp_path / "mine.yaml", posed=False)

    assert camera.setup.pose is not None


@pytest.mark.parametrize(("height", "told"), [("76 mm", False), ("75 mm", True), ("-1 m", True)])
def test_a_camera_hangs_above_the_robot(tmp_path: Path, height: str, told: bool) -> None:
    pose = f", pose: {{at: [0 mm, 0 mm, {height}], turn: [180 deg, 0 deg, 0 deg]}}"

    assert bool(faults(tmp_path, (POSE, POSE + pose))) is told


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        ("[170, 130, 40]", "[10, 255, 255]", False),  # red
        ("[100, 130, 40]", "[125, 120, 255]", True),
        ("[100, 130, 40]", "[125, 255, 30]", True),
    ],
)
def test_a_colour_is_between_its_limits(tmp_path: Path, low: str, high: str, told: bool) -> None:
    tags = 'robot: {tags: aruco_4x4_50, size: 24 mm, height: 75 mm, on: {"0": bend_1}}'
    marker = f"hsv: [{low}, {high}], size: 25 mm, height: 75 mm, on: bend_1"

    found = faults(tmp_path, (tags, f"robot: {{marker: {{{marker}}}}}"))
    assert bool(found) is told


def test_a_shutter_is_open_for_no_longer_than_from_picture_to_picture(tmp_path: Path) -> None:
    source = "source: {device: 0, size: [640, 480]}"
    drawn = "source: {synthetic: {camera: {shutter: %s}}, size: [640, 480], rate: 10 Hz}"

    assert faults(tmp_path, (source, drawn % "90 ms")) == []
    assert "the `shutter` is open" in faults(tmp_path, (source, drawn % "110 ms"))[0]
