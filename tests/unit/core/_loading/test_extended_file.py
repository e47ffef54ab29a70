"""A file that extends another one: what is merged, and where its faults are shown."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from pirate_sm.core._loading.problems import LoadError, Problems
from pirate_sm.core._loading.references import read_extended
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.core._loading.yaml.document import parse_document

ROOT = Path(__file__).resolve().parents[4]
PIRATE, IMU = ROOT / "hardware_profiles" / "pirate_ii", ROOT / "hardware_profiles" / "pirate_ii_imu"

BASE = """\
name: eel
parts:
  head: {joints: [a, b], long: 1 m}
  tail: {joints: [c], long: 2 m}
words: [one, two]
said: >-
  a text
  over two lines
"""


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "base").mkdir()
    (tmp_path / "base" / "eel.yaml").write_text(BASE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def over(files: Path, text: str) -> Path:
    path = files / "mine.yaml"
    path.write_text(f"extends: base/eel.yaml\n{text}")
    return path


def test_mappings_are_merged_and_anything_else_is_replaced(files):
    document = read_extended(
        over(files, "parts: {head: {joints: [d]}, fin: {long: 3 m}}\nname: x\n")
    )

    assert document.data == {
        "name": "x",
        "parts": {
            "head": {"joints": ["d"], "long": "1 m"},
            "tail": {"joints": ["c"], "long": "2 m"},
            "fin": {"long": "3 m"},
        },
        "words": ["one", "two"],
        "said": "a text over two lines",
    }


@pytest.mark.parametrize(
    ("path", "place", "excerpt"),
    [
        (("parts", "head", "joints"), "mine.yaml:2:24", "parts: {head: {joints: [d]}}"),
        (("parts", "head", "long"), "base/eel.yaml:3:32", "  head: {joints: [a, b], long: 1 m}"),
        (("parts", "tail", "joints", 0), "base/eel.yaml:4:19", "  tail: {joints: [c], long: 2 m}"),
        (("parts", "head"), "mine.yaml:2:15", "parts: {head: {joints: [d]}}"),
        (("parts", "head", "joints", 7), "mine.yaml:2:24", "parts: {head: {joints: [d]}}"),
        (("words", 1), "base/eel.yaml:5:14", "words: [one, two]"),
    ],
)
def test_a_fault_is_shown_in_the_file_where_the_value_stands(files, path, place, excerpt):
    problems = Problems(read_extended(over(files, "parts: {head: {joints: [d]}}\n")))
    problems.add("value", path, "is wrong")

    (found,) = problems.all
    assert (str(found.place), found.excerpt) == (place, excerpt)


def test_a_place_inside_a_text_is_found_in_its_own_file(files):
    document = read_extended(over(files, "name: longer\n"))
    assert str(document.place_of(("said",), offset=9)) == "base/eel.yaml:8:5"


def test_its_complete_text_needs_no_other_file(files):
    document = read_extended(over(files, "parts: {fin: {long: 3 m}}\n"))
    assert parse_document(document.complete_text, "alone").data == document.data
    assert document.text.startswith("extends:")


def test_a_file_that_extends_nothing_is_its_own_text(files):
    document = read_extended(files / "base" / "eel.yaml")
    assert document.complete_text == document.text == BASE


@pytest.mark.parametrize(
    ("extends", "message"),
    [
        ("base/cod.yaml", "base/cod.yaml: there is no such file"),
        ("mine.yaml", "these files extend each other"),
        ("[a]", "expected the path of the file that this one extends"),
        ("base", "base: is a directory"),
    ],
)
def test_a_base_that_cannot_be_read_is_a_fault_of_the_key(files, extends, message):
    path = files / "mine.yaml"
    path.write_text(f"name: x\nextends: {extends}\n")
    with pytest.raises(LoadError) as caught:
        read_extended(path)

    assert str(caught.value).startswith("mine.yaml:2:10: ")
    assert message in str(caught.value)


def test_files_that_extend_each_other_are_refused(files):
    (files / "a.yaml").write_text("extends: b.yaml\n")
    (files / "b.yaml").write_text("extends: a.yaml\n")
    with pytest.raises(LoadError, match="these files extend each other"):
        read_extended(files / "a.yaml")


def test_a_fault_of_the_base_keeps_its_place(files):
    (files / "base" / "eel.yaml").write_text("a: 1\na: 2\n")
    with pytest.raises(LoadError) as caught:
        read_extended(over(files, "name: x\n"))
    assert caught.value.problems[0].place.file == "base/eel.yaml"
    assert caught.value.problems[0].place.line == 2


# --- the robot that is made like this -----------------------------------------------------------


@pytest.mark.thorough
def test_the_robot_with_the_inertial_unit_adds_two_commands_and_two_states():
    usual, imu = load_robot(PIRATE), load_robot(IMU)

    assert len(usual.table.commands) == 14
    assert len(usual.table.configurations) == 176
    assert set(imu.table.commands) - set(usual.table.commands) == {
        "AlignHorizontal",
        "AlignVertical",
    }
    rotation = imu.table.regions.index("RotationState")
    for place, (old, new) in enumerate(zip(usual.table.states, imu.table.states, strict=True)):
        more = ("AlignedHorizontal", "AlignedVertical") if place == rotation else ()
        assert new == (*old, *more)


@pytest.mark.thorough
def test_what_it_does_not_name_is_as_in_the_robot_that_it_extends():
    usual, imu = load_robot(PIRATE).profile, load_robot(IMU).profile

    for name in type(usual).model_fields:
        if name not in {
            *("robot", "description", "actuation", "commands", "seen", "postures", "serial")
        }:
            assert getattr(imu, name) == getattr(usual, name), name
    for name, command in usual.commands.items():
        assert imu.commands[name] == command
    assert imu.postures["slack"][-1] == usual.postures["slack"][-1]


def test_in_the_old_configurations_the_old_commands_lead_to_the_same():
    usual, imu = load_robot(PIRATE).table, load_robot(IMU).table
    for here, states in enumerate(usual.configurations):
        there = imu.index_of(states)
        assert there is not None
        for command, name in enumerate(usual.commands):
            after = usual.configurations[usual.follow(here, command)]
            other = imu.follow(there, imu.commands.index(name))
            assert imu.configurations[other] == after


def test_a_fault_in_its_profile_is_shown_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for folder in (PIRATE, IMU):
        shutil.copytree(folder, tmp_path / folder.name)
    monkeypatch.chdir(tmp_path)
    own, base = tmp_path / "pirate_ii_imu/profile.yaml", tmp_path / "pirate_ii/profile.yaml"
    own.write_text(own.read_text().replace("{level: 90 deg}", "{level: 90 mm}"))
    base.write_text(
        base.read_text().replace("AlignedRight: {rotate: 90 deg}", "AlignedRight: {rotate: 90 kg}")
    )
    with pytest.raises(LoadError) as caught:
        load_robot(tmp_path / "pirate_ii_imu")

    files = {problem.place.file: problem.excerpt.strip() for problem in caught.value.problems}
    assert files == {
        "pirate_ii_imu/profile.yaml": "AlignedVertical: {rotate: {level: 90 mm}}",
        "pirate_ii/profile.yaml": "AlignedRight: {rotate: 90 kg}",
    }
