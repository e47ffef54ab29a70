from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import pirate_sm
from pirate_sm.core.documents import read_document

from ..conftest import NEWT


def test_everything_is_listed(pirate: Any) -> None:
    result = pirate("list")

    assert result.exit_code == 0
    for word in (
        "robots:", "pirate_ii", "ClampFront", "also UnclampFront", "gamma_1", "an angle",
        "detector", "close | in | past", "gamma_2_stiff", "mitre_bend", "mitre_90",
        "backends:", "the kinematic simulator", "detectors:", "dead reckoning",
    ):  # fmt: skip
        assert word in result.stdout


def test_one_thing_of_another_robot_is_listed(pirate: Any) -> None:
    result = pirate("list", "commands", "--robot", NEWT)

    assert "HoldNose" in result.stdout
    assert "ClampFront" not in result.stdout
    assert "missions:" not in result.stdout


def test_unknown_things_and_robots_are_refused(pirate: Any) -> None:
    assert pirate("list", "wheels").exit_code == 2
    result = pirate("list", "--robot", "pirate_3")
    assert result.exit_code == 2
    assert "did you mean 'pirate_ii'" in result.stderr


@pytest.mark.parametrize("backend", ["trace", "sim"])
def test_a_new_mission_runs(
    pirate: Any, pirate_run: Any, backend: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    assert pirate("new", "mission", "hello").exit_code == 0
    result = pirate_run("hello.yaml", "--backend", backend, "--quiet")
    assert (result.exit_code, result.stderr) == (0, "")


@pytest.mark.parametrize("backend", ["trace", "sim"])
def test_a_new_robot_runs_its_mission_and_takes_a_new_one(
    pirate: Any, pirate_run: Any, backend: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    assert pirate("new", "robot", "crawler").exit_code == 0
    first = pirate_run("crawler/first_mission.yaml", "--backend", backend, "--quiet")
    assert pirate("new", "mission", "mine", "--robot", "crawler").exit_code == 0
    second = pirate_run("mine.yaml", "--backend", backend, "--quiet")
    assert (first.exit_code, second.exit_code) == (0, 0), first.output + second.output
    assert str(tmp_path) not in Path("mine.yaml").read_text("utf-8")


def test_editors_find_the_schemas_of_what_is_new(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    pirate("new", "robot", "crawler")
    pirate("new", "mission", "mine", "--robot", "crawler")
    pirate("new", "mission", "hello")
    pirate("new", "mission", "again")

    files = sorted(Path().rglob("*.yaml"))
    assert len(files) == 8
    for file in files:
        schema = file.parent / _schema_named_in(file)
        validator = jsonschema.Draft7Validator(json.loads(schema.read_text("utf-8")))
        assert list(validator.iter_errors(read_document(file).data)) == []
    assert _schema_named_in(Path("mine.yaml")) == "crawler/mission.schema.json"
    assert _schema_named_in(Path("again.yaml")) == "pirate_ii.mission.schema.json"


def _schema_named_in(file: Path) -> str:
    first = file.read_text("utf-8").splitlines()[0]
    assert first.startswith("# yaml-language-server: $schema=")
    return first.partition("=")[2]


def test_a_schema_is_printed(pirate: Any) -> None:
    result = pirate("schema", "mission", "--robot", NEWT)

    assert result.exit_code == 0
    commands = json.loads(result.stdout)["definitions"]["CommandName"]["enum"]
    assert "HoldNose" in commands
    assert json.loads(pirate("schema", "chart").stdout)["properties"].keys() == {
        "name", "description", "states",
    }  # fmt: skip


def test_only_missions_have_a_schema_for_each_robot(pirate: Any) -> None:
    result = pirate("schema", "pipe", "--robot", NEWT)

    assert result.exit_code == 2
    assert "leave out --robot" in result.stderr


def test_nothing_is_overwritten(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hello.yaml").write_text("mine", encoding="utf-8")
    Path("crawler").mkdir()

    for kind, name in (("mission", "hello"), ("robot", "crawler")):
        result = pirate("new", kind, name)
        assert result.exit_code == 2
        assert "is there already" in result.stderr
    assert Path("hello.yaml").read_text("utf-8") == "mine"
    assert list(Path("crawler").iterdir()) == []


@pytest.mark.parametrize("name", ["", "../up", "two words", "1st", "a" * 65])
def test_a_name_must_be_a_name(
    pirate: Any, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    for kind in ("mission", "robot"):
        assert pirate("new", kind, name).exit_code == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_a_copy_of_a_robot_is_found_by_its_name_wherever_a_robot_is_asked_for(
    pirate: Any, pirate_run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    made = pirate("new", "robot", "ours", "--like", "pirate_ii")
    assert (made.exit_code, made.stderr) == (0, "")
    assert "robot: ours\n" in Path("ours/profile.yaml").read_text("utf-8")
    assert Path("ours/messages/State.msg").exists()
    ran = pirate_run("mitre_bend", "--robot", "ours", "--backend", "trace", "--plain")
    assert ran.exit_code == 0, ran.output
    assert "mitre_bend on ours" in ran.stdout
    for command in (
        ("check", "ours"),
        ("check", "mitre_bend", "--robot", "ours"),
        ("explain", "careful", "--robot", "ours"),
        ("list", "commands", "--robot", "ours"),
    ):
        assert pirate(*command).exit_code == 0, command


def test_a_copy_has_no_zeros_of_another_robots_joints(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    pirate("new", "robot", "ours", "--like", "pirate_ii")
    Path("ours/calibration-2026-11-21.yaml").write_text("format: 1\n", "utf-8")

    assert pirate("new", "robot", "next", "--like", "ours").exit_code == 0
    assert Path("next/profile.yaml").exists()
    assert not list(Path("next").glob("calibration-*"))


def test_a_robot_that_extends_another_one_is_not_copied(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    refused = pirate("new", "robot", "ours", "--like", "pirate_ii_imu")
    assert refused.exit_code == 2
    assert "'pirate_ii_imu' extends ../pirate_ii/profile.yaml" in refused.stderr
    assert not Path("ours").exists()


@pytest.mark.parametrize(
    ("kind", "like"), [("camera", "setup_1"), ("camera", None), ("panel", None)]
)
def test_a_copy_of_a_camera_or_a_panel_is_clean_and_has_its_own_name(
    pirate: Any, kind: str, like: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    made = pirate("new", kind, "ours", *([] if like is None else ["--like", like]))
    assert (made.exit_code, made.stderr) == (0, "")
    assert read_document(Path("ours.yaml"), "ours.yaml").data[kind] == "ours"
    assert Path(f"{kind}.schema.json").exists()
    assert pirate("check", "ours.yaml").exit_code == 0
    assert pirate("new", kind, "ours").exit_code == 2  # it is there already


def test_what_is_written_for_people_names_no_file_that_only_the_sources_have() -> None:
    package = Path(pirate_sm.__file__).parent
    texts = [
        *(package / "cli/templates").rglob("*.yaml"),
        *package.glob("checking/catalogue/*.yaml"),
    ]
    texts += (package / "cli/help").glob("*.txt")
    naming = [path.name for path in texts if re.search(r"docs/\w+\.md", path.read_text("utf-8"))]

    assert len(texts) > 40
    assert naming == []
