"""Which files a check is about."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.checking.project_files import DEEPEST_FOLDER, find_targets
from pirate_sm.core import library
from pirate_sm.core.documents import FileKind
from pirate_sm.core.errors import UsageError

MISSION = "mission: m\nphases: {}\n"


def write(path: str, text: str = MISSION) -> Path:
    file = Path(path)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return file


def found(*paths: str) -> list[tuple[str, str]]:
    return [(each.kind.value, str(each.path)) for each in find_targets(paths).targets]


def test_without_a_path_it_is_the_project_in_the_working_directory() -> None:
    write("sequences/deep/down/m.yaml")
    write("hardware_profiles/r/profile.yaml", "boards: []\n")
    write("elsewhere/n.yaml")
    write("docker.yaml", "services: {}\n")

    assert found() == [
        ("robot", "hardware_profiles/r/profile.yaml"),
        ("mission", "sequences/deep/down/m.yaml"),
    ]


def test_a_mission_beside_the_folders_of_a_project_is_checked_with_it() -> None:
    write("sequences/m.yaml")
    write("n.yaml")

    assert found() == [("mission", "n.yaml"), ("mission", "sequences/m.yaml")]


def test_without_the_folders_of_a_project_it_is_what_is_there_not_what_is_shipped() -> None:
    write("broken.yaml")
    write("deep/down/m.yaml")

    assert found() == [("mission", "broken.yaml"), ("mission", "deep/down/m.yaml")]
    assert find_targets([]).where == (".",)


def test_without_a_folder_for_missions_they_may_be_anywhere() -> None:
    write("hardware_profiles/r/profile.yaml", "boards: []\n")
    write("missions/m.yaml")

    assert found() == [
        ("robot", "hardware_profiles/r/profile.yaml"),
        ("mission", "missions/m.yaml"),
    ]


def test_in_a_folder_only_what_is_ours_counts() -> None:
    write("a/m.yaml")
    write("a/n.yml")
    write("a/docker.yaml", "services: {}\n")
    write("a/notes.txt")
    write("a/.hidden/m.yaml")
    write("a/.m.yaml")

    assert found("a") == [("mission", "a/m.yaml"), ("mission", "a/n.yml")]


def test_a_file_that_is_named_counts_whatever_it_is() -> None:
    write("notes.txt", "hello")
    write("m.txt")

    assert found("notes.txt", "m.txt") == [("mission", "m.txt"), ("other file", "notes.txt")]


def test_a_file_is_taken_once() -> None:
    write("a/m.yaml")
    Path("a/same.yaml").symlink_to("m.yaml")

    assert len(found("a/m.yaml", "a", "./a/../a/m.yaml")) == 1


def test_a_chart_brings_its_robot() -> None:
    write("r/profile.yaml", "boards: []\n")
    write("r/chart.yaml", "states: {r: {parallel: true}}\n")

    assert found("r/chart.yaml") == [("robot", "r/profile.yaml"), ("chart", "r/chart.yaml")]


def test_a_shipped_mission_is_known_by_its_name() -> None:
    (target,) = find_targets([library.missions()[0].stem]).targets

    assert (target.kind, target.path) == (FileKind.MISSION, library.missions()[0])


@pytest.mark.parametrize("path", ["nowhere.yaml", "no/where", "null\0byte", "x" * 5000])
def test_a_path_that_leads_nowhere_is_refused(path: str) -> None:
    with pytest.raises(UsageError, match="there is no file or folder"):
        find_targets([path])


def test_a_misspelt_mission_is_understood() -> None:
    with pytest.raises(UsageError, match="did you mean 'mitre_bend'"):
        find_targets(["mitre_bent"])


def test_links_that_lead_in_a_circle_end() -> None:
    write("a/m.yaml")
    Path("a/up").symlink_to("..", target_is_directory=True)
    Path("a/self").symlink_to("self")
    Path("a/loop.yaml").symlink_to("loop.yaml")

    assert found("a") == [("mission", "a/m.yaml"), ("unreadable file", "a/loop.yaml")]


def test_folders_without_end_are_reported() -> None:
    write("/".join(["d"] * (DEEPEST_FOLDER + 3)) + "/m.yaml")

    result = find_targets(["d"])
    assert result.targets == ()
    assert [each.code for each in result.findings] == ["check.folder"]


def test_a_folder_without_anything_to_check_is_reported() -> None:
    write("a/notes.txt")

    (finding,) = find_targets(["a"]).findings
    assert (finding.code, finding.place.file) == ("check.nothing", "a")


@pytest.mark.parametrize("folder", ["sequences", "elsewhere"])
def test_a_project_without_anything_to_check_is_reported(folder: str) -> None:
    Path(folder).mkdir()

    (finding,) = find_targets([]).findings
    assert (finding.code, finding.place.file) == ("check.nothing", ".")
