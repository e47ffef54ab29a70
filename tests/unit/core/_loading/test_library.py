"""Robots, missions and pipes by name or path."""

from __future__ import annotations

import shutil
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core import library
from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core.errors import UsageError

ROOT = Path(__file__).resolve().parents[4]
NEWT = ROOT / "tests" / "robots" / "newt"


def test_what_is_shipped_is_found_by_name():
    assert library.find_robot("pirate_ii") == ROOT / "hardware_profiles" / "pirate_ii"
    assert library.find_mission("mitre_bend") == ROOT / "sequences" / "mitre_bend.yaml"
    assert library.find_pipe("mitre_90") == ROOT / "sequences" / "pipes" / "mitre_90.yaml"


def test_everything_listed_is_found_by_its_name():
    for path in library.robots():
        assert library.find_robot(path.name) == path
    for path in library.missions():
        assert library.find_mission(path.stem) == path
    for path in library.pipes():
        assert library.find_pipe(path.stem) == path


@pytest.mark.parametrize(
    ("find", "name", "message"),
    [
        (library.find_robot, "pirat_ii", "there is no robot 'pirat_ii'; did you mean 'pirate_ii'?"),
        (library.find_mission, "mitre-bend", "did you mean 'mitre_bend'?"),
        (library.find_pipe, "vertica", "did you mean 'vertical'?"),
        (
            library.find_robot,
            "zzz",
            "there is no robot 'zzz'; expected one of pirate_ii, pirate_ii_imu",
        ),
        (library.find_robot, "", "there is no robot ''"),
        (library.find_robot, "no/where", "there is no robot at 'no/where': expected a folder with"),
        (library.find_robot, ".", "there is no robot at '.'"),
        (library.find_robot, "a" * 5000, "there is no robot 'aaa"),
        (library.find_robot, "a/" * 5000, "there is no robot at 'a/a"),
        (library.find_mission, "a\0b", "there is no mission 'a\\0b'"),
        (library.find_mission, "ä" * 5000, "there is no mission 'ä"),
        (library.find_pipe, "ä" * 5000, "there is no pipe 'ä"),
    ],
)
def test_an_unknown_name_is_refused_with_the_nearest(find, name, message):
    with pytest.raises(UsageError) as caught:
        find(name)

    assert message in str(caught.value)
    assert len(str(caught.value)) < 600


def test_names_that_a_message_has_no_room_for_are_counted():
    with pytest.raises(UsageError, match=r"one of climb, .*, … \(\d more\)$"):
        library.find_mission("z" * 60)


def test_a_path_goes_to_the_file_itself(tmp_path):
    file = tmp_path / "mine.yaml"
    file.touch()

    assert library.find_mission(str(file)) == file


def test_a_robot_is_a_folder_or_the_profile_in_it():
    assert library.find_robot(str(NEWT)) == NEWT
    assert library.find_robot(str(NEWT / "profile.yaml")) == NEWT
    assert library.find_robot("../newt", NEWT) == NEWT
    assert library.find_robot("newt", NEWT.parent) == NEWT


def test_what_stands_beside_comes_before_what_is_shipped(tmp_path):
    for name in ("mitre_bend.yaml", "mitre_90.yml", "other.yaml"):
        (tmp_path / name).touch()
    (tmp_path / "pipes").mkdir()
    (tmp_path / "pipes" / "vertical.yaml").touch()

    assert library.find_mission("mitre_bend", tmp_path) == tmp_path / "mitre_bend.yaml"
    assert library.find_pipe("mitre_90", tmp_path) == tmp_path / "mitre_90.yml"
    assert library.find_pipe("vertical", tmp_path) == tmp_path / "pipes" / "vertical.yaml"
    assert library.find_pipe("./other.yaml", tmp_path) == tmp_path / "./other.yaml"
    assert library.find_mission("enter_2d", tmp_path) == ROOT / "sequences" / "enter_2d.yaml"


def test_a_robot_that_hides_a_shipped_one_is_reported(tmp_path):
    own = tmp_path / "pirate_ii"
    shutil.copytree(ROOT / "hardware_profiles" / "pirate_ii", own)
    mission = tmp_path / "m.yaml"
    told = f"the robot 'pirate_ii' is the one in {own}, not the shipped one of that name"

    shipped = (ROOT / "sequences" / "climb.yaml").read_text("utf-8")
    for robot, notices in (("pirate_ii", (told,)), ("./pirate_ii", ())):
        text = shipped.replace("robot: pirate_ii", f"robot: {robot}")
        mission.write_text(text, encoding="utf-8")
        loaded = load_mission(mission)
        assert loaded.loaded_robot.folder == own
        assert loaded.notices == notices
        assert tuple(problem.message for problem in loaded.problems) == notices
    assert load_mission(ROOT / "sequences" / "climb.yaml").notices == ()


@pytest.mark.parametrize("name", ["none.yaml", "mine.yaml/none.yaml"])
def test_a_path_must_lead_somewhere(tmp_path, name):
    (tmp_path / "mine.yaml").touch()

    for kind, find in (("mission", library.find_mission), ("pipe", library.find_pipe)):
        with pytest.raises(UsageError, match=f"there is no {kind} at '{tmp_path / name}'"):
            find(str(tmp_path / name))


def test_a_path_in_a_file_must_lead_somewhere(tmp_path):
    with pytest.raises(UsageError, match=r"there is no pipe at '\./none\.yaml'"):
        library.find_pipe("./none.yaml", tmp_path)


@given(name=st.text(max_size=300))
def test_any_name_is_found_or_refused(name):
    for find in (library.find_robot, library.find_mission, library.find_pipe):
        for beside in (None, ROOT / "sequences"):
            with suppress(UsageError):
                assert isinstance(find(name, beside), Path)


def test_a_name_that_lacks_only_the_ending_of_a_file_here_is_recognised(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "first.yaml").touch()
    with pytest.raises(UsageError, match=r"there is no mission 'first'; did you mean 'first.yaml'"):
        library.find_mission("first")
