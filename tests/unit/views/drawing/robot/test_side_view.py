"""A robot from the side: to scale, with the way in which each setpoint moves it."""

from __future__ import annotations

import re
import shutil
from itertools import pairwise
from math import hypot
from pathlib import Path

import pytest

from pirate_sm.checking.robot.check_robot import robot_findings
from pirate_sm.cli.commands.new import write_robot
from pirate_sm.cli.options.files import NewRobotOptions
from pirate_sm.core.loading import LoadedRobot, load_robot
from pirate_sm.views.drawing.side_view import SideView, side_text, side_view
from pirate_sm.views.drawing.side_view_svg import side_svg

ROOT = Path(__file__).resolve().parents[5]
PIRATE, NEWT = ROOT / "hardware_profiles" / "pirate_ii", ROOT / "tests" / "robots" / "newt"


def viewed(robot: LoadedRobot) -> SideView:
    return side_view(robot, {each.place: each.message for each in robot_findings(robot)})


def edited(old: str, new: str, folder: Path) -> SideView:
    shutil.copytree(NEWT, folder / "newt")
    profile = folder / "newt" / "profile.yaml"
    text = profile.read_text("utf-8")
    assert text.count(old) == 1
    profile.write_text(text.replace(old, new), "utf-8")
    return viewed(load_robot(folder / "newt"))


def row(view: SideView, name: str) -> dict[float, str]:
    (found,) = (each.cells for each in view.rows if each.name.strip() == name)
    return dict(found)


@pytest.fixture(params=["pirate_ii", "newt", "template"])
def robot(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    if request.param != "template":
        return load_robot(PIRATE if request.param == "pirate_ii" else NEWT)
    monkeypatch.chdir(tmp_path)
    write_robot(NewRobotOptions(name="beast"))
    return load_robot(tmp_path / "beast")


def test_each_positive_duty_moves_the_robot_as_the_wall_of_its_wheel_says() -> None:
    view = viewed(load_robot(NEWT))

    assert row(view, "positive setpoint") == {0: "→", 1: "← ↑", 2: "→ ↑", 3: "←"}
    assert row(view, "Ahead") == {0: "→", 1: "→", 2: "→", 3: "→"}
    assert row(view, "BothHeld") == {1: "↓", 2: "↑"}
    assert row(view, "Loose") == {1: "0°", 2: "0°"}
    assert view.pressed == {1: "↓", 2: "↑"}
    assert "Resting" not in side_text(view)


def test_a_roll_joint_has_its_own_column_between_two_wheels() -> None:
    view = viewed(load_robot(PIRATE))

    assert row(view, "positive setpoint")[2.5] == "↺"
    assert row(view, "AlignedLeft") == {2.5: "-90°"}
    assert row(view, "RearClampedFrontBending, stage 2") == {1: "0", 2: "↓", 3: "↓", 4: "↑"}


def test_of_a_sound_robot_nothing_is_marked(robot: LoadedRobot) -> None:
    view = viewed(robot)

    assert "✗" not in side_text(view)
    assert "✗" not in side_svg(view)


@pytest.mark.parametrize(
    ("old", "new", "line", "mark"),
    [
        ("Ahead: {drive_a: 80 %, drive_b: -", "Ahead: {drive_a: 80 %, drive_b: ", "  Ahead", "←✗"),
        ("BothHeld: {fold_neck: -50 %", "BothHeld: {fold_neck: 50 %", "  BothHeld", "↑✗"),
        ("right_fore, part: nose, direction: -1", "right_fore, part: nose, direction: 1", "", "1✗"),
        ("angle: roll_b, speed: spin_b", "angle: roll_a, speed: spin_b", "", "2✗"),
        ("joint: hip, mirrors: true", "joint: hip", "", "3✗"),
    ],
    ids=["drive", "clamp", "direction", "signal", "mirrors"],
)  # fmt: skip
def test_what_is_wrong_is_marked_where_it_is_drawn(
    old: str, new: str, line: str, mark: str, tmp_path: Path
) -> None:
    view = edited(old, new, tmp_path)
    picture, _, notes = side_text(view).partition("To scale")

    marked = [each for each in picture.splitlines() if "✗" in each]
    assert marked
    assert all(each.startswith(line) for each in marked)
    assert mark in marked[0]
    assert notes.count("✗") == len(view.notes) > 0
    assert 'class="title bad"' in side_svg(view)


def test_wheels_and_links_are_to_scale_in_both_pictures(robot: LoadedRobot) -> None:
    view, body = viewed(robot), robot.profile.body
    pattern = r'<circle class="wheel" cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"'
    circles = [tuple(map(float, each)) for each in re.findall(pattern, side_svg(view))]
    scale = circles[0][2] / body.wheel_radius
    count = len(body.wheels)
    straight, clamped = circles[:count], circles[count:]

    assert len(clamped) == count
    for drawn in (straight, clamped):
        for link, (ahead, behind) in zip(body.links, pairwise(drawn), strict=True):
            far = hypot(ahead[0] - behind[0], ahead[1] - behind[1])
            assert far / scale == pytest.approx(link.length, rel=0.005)
    high = max(y for _, y, _ in clamped) - min(y for _, y, _ in clamped)
    assert high / scale + 2 * body.wheel_radius == pytest.approx(view.diameter_m, rel=0.005)


def test_the_picture_in_text_fits_a_terminal_and_names_every_wheel(robot: LoadedRobot) -> None:
    text = side_text(viewed(robot))
    drawn, count = text.partition("positive setpoint")[0], len(robot.profile.body.wheels)

    assert max(map(len, text.splitlines())) <= 80
    assert sorted(re.findall(r"\d", drawn)) == [str(n + 1) for n in range(count)]


def test_the_slot_of_each_motor_is_named_with_its_board(robot: LoadedRobot) -> None:
    drawn = side_svg(viewed(robot))

    for board in robot.profile.boards:
        for number, slot in enumerate(board.slots):
            assert (f"board {board.id} slot {number}<" in drawn) == bool(slot.drives)
