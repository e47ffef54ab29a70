"""Settings: which value counts, who may set what, and what is wrong with a file."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from pirate_sm.cli import settings
from pirate_sm.running.recording.read.reader import read_recording

from .conftest import NEWT

Pirate = Callable[..., Result]


@pytest.fixture
def user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The person's own file, which is not there yet; the working folder is inside a project's."""
    monkeypatch.setattr(settings, "user_file", lambda: tmp_path / "home" / "config.toml")
    monkeypatch.delenv("PIRATE_SM_RUNS")
    (tmp_path / "home").mkdir()
    (tmp_path / "project" / "inside").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "project" / "inside")
    return tmp_path / "home" / "config.toml"


@pytest.fixture
def project(user: Path, tmp_path: Path) -> Path:
    """The project's file, which is not there yet."""
    return tmp_path / "project" / "pirate.toml"


def shown(pirate: Pirate) -> dict[str, Any]:
    result = pirate("config", "--format", "json")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)["settings"]


def begun(result: Result) -> dict[str, Any]:
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout.partition("\n")[0])


def test_without_files_everything_is_built_in(user: Path, pirate: Pirate) -> None:
    found = shown(pirate)

    assert {each["source"] for each in found.values()} == {"built in"}
    assert (found["backend"]["value"], found["runs"]["value"]) == ("sim", "runs")


def test_a_project_comes_before_the_person_and_the_command_line_before_both(
    user: Path, project: Path, pirate: Pirate, monkeypatch: pytest.MonkeyPatch
) -> None:
    user.write_text('theme = "light"\nbackend = "sim"\nruns = "mine"\n', "utf-8")
    project.write_text('\nbackend = "trace"\n', "utf-8")
    monkeypatch.setenv("PIRATE_SM_RUNS", "")
    found = shown(pirate)

    assert found["backend"] == {"value": "trace", "source": f"{project}:2", "refused": None}
    assert found["theme"] == {"value": "light", "source": f"{user}:1", "refused": None}
    assert found["runs"]["source"] == "PIRATE_SM_RUNS"
    patrol = str(NEWT / "patrol.yaml")
    assert begun(pirate("run", patrol, "--json"))["backend"] == "trace"
    assert begun(pirate("run", patrol, "--json", "--backend", "sim"))["backend"] == "sim"


def test_a_run_says_what_the_project_sets_and_keeps_it(
    project: Path, pirate: Pirate, tmp_path: Path
) -> None:
    project.write_text('backend = "trace"\nruns = "kept"\n', "utf-8")
    result = pirate("run", str(NEWT / "patrol.yaml"), "--quiet")

    assert result.exit_code == 0
    assert result.stderr.splitlines()[0] == f"backend = 'trace', from {project}:1"
    (kept,) = (tmp_path / "project" / "kept").glob("*.mcap")
    assert read_recording(kept).header.options["backend"] == "trace"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('backend = "serial"', "backend = 'serial' reaches a robot"),
        ('backend = "sim"\nruns = "../elsewhere"', "is outside of the project"),
    ],
)
def test_a_project_reaches_no_robot_and_writes_nowhere_else_unless_it_is_trusted(
    user: Path, project: Path, pirate: Pirate, text: str, why: str, tmp_path: Path
) -> None:
    project.write_text(text, "utf-8")
    result = pirate("run", str(NEWT / "patrol.yaml"))

    assert result.exit_code == 2
    assert why in result.stderr
    assert "add the folder to `trusted`" in result.stderr
    checked = pirate("check", "--format", "json")
    assert "check.untrusted" in checked.stdout
    assert "check.untrusted" not in pirate("check", str(NEWT / "patrol.yaml")).stdout
    Path("other").mkdir()
    assert "check.untrusted" not in pirate("check", "other", "--format", "json").stdout
    assert "check.untrusted" in pirate("check", "other", "..", "--format", "json").stdout
    user.write_text(f'trusted = ["{tmp_path}"]', "utf-8")
    assert {each["refused"] for each in shown(pirate).values()} == {None}
    result = pirate("run", str(NEWT / "patrol.yaml"))
    assert "add the folder to `trusted`" not in result.stderr
    assert "check.untrusted" not in pirate("check", "--format", "json").stdout


def test_a_projects_port_and_robot_are_not_used_for_a_real_robot(
    project: Path, pirate: Pirate
) -> None:
    project.write_text('port = "/dev/null"', "utf-8")
    refused = pirate("doctor")
    assert (refused.exit_code, "reaches a robot" in refused.stderr) == (2, True)
    project.write_text(f'robot = "{NEWT}"', "utf-8")
    refused = pirate("doctor", "--port", "/dev/null")
    assert (refused.exit_code, "is not a bundled robot" in refused.stderr) == (2, True)


def test_a_port_is_no_option_of_a_simulated_run(user: Path, pirate: Pirate) -> None:
    user.write_text('port = "/dev/null"', "utf-8")

    assert begun(pirate("run", str(NEWT / "patrol.yaml"), "--json"))["backend"] == "sim"


def test_the_doctor_takes_the_port_of_the_person(user: Path, pirate: Pirate) -> None:
    assert "name the port, --port" in pirate("doctor").stderr
    user.write_text(f'port = "{user.parent / "no_port"}"', "utf-8")

    assert "no_port" in pirate("doctor").stderr


def test_what_is_refused_does_not_matter_where_the_command_line_says_otherwise(
    project: Path, pirate: Pirate
) -> None:
    project.write_text('backend = "serial"\nport = "/dev/null"', "utf-8")
    result = pirate("run", str(NEWT / "patrol.yaml"), "--backend", "trace", "--json", "--no-record")

    assert begun(result)["backend"] == "trace"


def test_all_faults_of_both_files_are_listed_with_their_places(
    user: Path, project: Path, pirate: Pirate
) -> None:
    user.write_text('theme = "lihgt"\n[rnus]\n', "utf-8")
    project.write_text('bakend = "sim"\n  backend = 3\ntrusted = ["/"]\n', "utf-8")
    result = pirate("config")

    assert result.exit_code == 2
    for said in (
        f"{user}:1:9: there is no theme 'lihgt'",
        "did you mean 'light'?",
        f"{user}:2:2: there is no setting 'rnus'",
        f"{project}:1:1: there is no setting 'bakend'",
        "did you mean 'backend'?",
        f"{project}:2:13: the value is 3",
        f"{project}:3:1: only the user's own file sets 'trusted'",
    ):
        assert said in result.stderr


@pytest.mark.parametrize(
    "text", [b'backend = "sim', b"a = 1 2", b"[" * 20_000, b"\xff", b"#" * 2_000_000]
)
def test_a_file_that_is_no_toml_is_refused(project: Path, pirate: Pirate, text: bytes) -> None:
    project.write_bytes(text)
    result = pirate("config")

    assert result.exit_code == 2
    assert str(project) in result.stderr
    assert "an internal error" not in result.stderr


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b'\nruns = "x', ":2:8: this text is not closed: end it with a quote"),
        (b'runs = "x\nbackend = "sim"\n', ":1:8: this text is not closed"),
        (b"theme = 'dark\n", ":1:9: this text is not closed"),
        (b'backend = "sim"\nruns = "\xff"\n', ":2:9: byte 0xff is not UTF-8; save the file as"),
        (b'runs = "a"\nruns = "b"\n', "this is set twice: leave one of the two lines out"),
        (b"runs = recordings\n", ":1:8: expected a value here, such as a text in quotes"),
        (b"runs\n", ":1:5: expected one setting in each line"),
        (b'runs = "a" theme = "dark"\n', ":1:12: expected one setting in each line"),
        (
            b"port = true\n",
            ":1:8: the value is true\n    port = true\n           ^\n  expected a text",
        ),
        (b"port = nan\n", ":1:8: the value is nan\n"),
        (b'runs = "a\\u0000b"\n', ":1:8: the value is"),
        (b"[port]\n", "the value is a table\n"),
        (b"runs = 1979-05-27\n", ":1:8: the value is 1979-05-27"),
    ],
)
def test_a_fault_of_a_file_has_its_place_and_says_what_to_write(
    project: Path, pirate: Pirate, text: bytes, said: str
) -> None:
    project.write_bytes(text)
    result = pirate("config")

    assert result.exit_code == 2
    assert result.stderr.startswith(f"{project}:")
    assert said in result.stderr


def test_nothing_is_read_of_a_projects_link_to_another_folder(
    project: Path, pirate: Pirate, tmp_path: Path
) -> None:
    secret = tmp_path.parent / f"{tmp_path.name}_secret"
    secret.write_text("password = hunter2", "utf-8")
    project.unlink(missing_ok=True)
    project.symlink_to(secret)

    result = pirate("config")
    assert result.exit_code == 2
    assert "this link leads out of the project's folder" in result.stderr
    assert "hunter2" not in result.output


@pytest.mark.parametrize(
    ("name", "better"),
    [("out.csv", "out.mcap"), ("a\x1b[31mb.mcap", "a__31mb.mcap"), ("a\nb.mcap", "a_b.mcap")],
)
def test_a_recording_has_the_name_of_an_mcap_file_that_a_terminal_can_show(
    pirate: Pirate, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, better: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = pirate("run", "mitre_bend", "--backend", "trace", "--record", name)

    assert result.exit_code == 2, result.output
    assert f"name it '{better}'; nothing has moved" in result.stderr
    assert [*tmp_path.glob("*.*")] == []


def test_a_file_may_begin_with_a_mark_of_its_encoding(project: Path, pirate: Pirate) -> None:
    project.write_bytes(b'\xef\xbb\xbftheme = "light"\r\n')

    assert shown(pirate)["theme"]["value"] == "light"


def test_all_lines_that_a_project_may_not_set_are_refused_at_once(
    project: Path, pirate: Pirate
) -> None:
    project.write_text('runs = "../elsewhere"\nport = "/dev/null"\nbackend = "serial"\n', "utf-8")
    result = pirate("run", str(NEWT / "patrol.yaml"))

    assert result.exit_code == 2
    for said in (
        f"{project}:1:8: runs = ",
        f"{project}:2:8: port = '/dev/null' reaches a robot",
        f"{project}:3:11: backend = 'serial' reaches a robot",
    ):
        assert said in result.stderr


@pytest.mark.thorough
@pytest.mark.parametrize("runs", ["taken", "taken/below", "/proc/nowhere"])
@pytest.mark.parametrize("where", ["project", "person", "environment"])
def test_a_folder_that_somebody_has_set_must_take_the_recording(
    where: str,
    runs: str,
    user: Path,
    project: Path,
    pirate: Pirate,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    (tmp_path / "project" / "taken").touch()
    folder = tmp_path / "project" / runs
    user.write_text(f"trusted = ['{tmp_path}']\n", "utf-8")
    if where == "environment":
        monkeypatch.setenv("PIRATE_SM_RUNS", str(folder))
        place = "PIRATE_SM_RUNS: "
    else:
        file = project if where == "project" else user
        file.write_text(f"trusted = ['{tmp_path}']\n" if file == user else "\n", "utf-8")
        with file.open("a", encoding="utf-8") as stream:
            stream.write(f"runs = '{folder}'\n")
        place = f"{file}:2:8: "
    result = pirate("run", str(NEWT / "patrol.yaml"), "--backend", "trace")

    assert result.exit_code == 2
    assert f"{place}recordings cannot be kept in '{folder}': " in result.stderr
    assert "nothing has moved" in result.stderr
    assert "--no-record runs without a recording" in result.stderr
    without = pirate("run", str(NEWT / "patrol.yaml"), "--backend", "trace", "--no-record")
    assert without.exit_code == 0
    campaign = pirate("campaign", "enter_2d", "--seeds", "1")
    assert campaign.exit_code == 2
    assert f"{place}recordings cannot be kept in '{folder}': " in campaign.stderr
    assert "--output names another folder" in campaign.stderr


def test_the_paths_are_said(user: Path, project: Path, pirate: Pirate) -> None:
    assert pirate("config", "path").stdout == f"{user}\n"
    project.touch()

    assert pirate("config", "path").stdout == f"{user}\n{project}\n"


@pytest.mark.parametrize("where", ["person", "environment"])
def test_a_tilde_is_the_home_of_the_person(
    where: str, user: Path, pirate: Pirate, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(user.parent))
    if where == "environment":
        monkeypatch.setenv("PIRATE_SM_RUNS", "~/kept")
    else:
        user.write_text('runs = "~/kept"', "utf-8")

    assert shown(pirate)["runs"]["value"] == str(user.parent / "kept")
    assert pirate("run", str(NEWT / "patrol.yaml"), "--backend", "trace").exit_code == 0
    assert len(list((user.parent / "kept").glob("*.mcap"))) == 1


def test_a_robot_may_be_named_from_the_home_of_the_person(
    user: Path, pirate: Pirate, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(user.parent))
    user.write_text('robot = "~/robots/newt"', "utf-8")

    assert shown(pirate)["robot"]["value"] == str(user.parent / "robots" / "newt")


def test_a_home_that_nobody_has_is_the_name_of_a_folder(
    user: Path, project: Path, pirate: Pirate, monkeypatch: pytest.MonkeyPatch
) -> None:
    user.write_text('trusted = ["~no.such.person"]\nruns = "~no.such.person/runs"', "utf-8")
    project.write_text('port = "/dev/null"', "utf-8")

    assert shown(pirate)["runs"]["value"] == "~no.such.person/runs"
    monkeypatch.setenv("PIRATE_SM_RUNS", "~no.such.person")
    assert shown(pirate)["runs"]["value"] == "~no.such.person"


@pytest.mark.parametrize("where", ["project", "person"])
@pytest.mark.parametrize("command", ["config", "run"])
def test_a_folder_or_a_broken_link_in_place_of_a_file_of_settings_is_refused(
    where: str, command: str, user: Path, project: Path, pirate: Pirate
) -> None:
    file = project if where == "project" else user
    words = ("config",) if command == "config" else ("run", str(NEWT / "patrol.yaml"))
    file.mkdir()
    result = pirate(*words)
    assert result.exit_code == 2
    assert f"{file}: is a directory; a TOML file is expected" in result.stderr

    file.rmdir()
    file.symlink_to("nowhere")
    result = pirate(*words)
    assert result.exit_code == 2
    assert f"{file}: there is no such file" in result.stderr
