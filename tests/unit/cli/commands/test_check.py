"""`pirate check` and `pirate explain` as somebody calls them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from checking.small_missions import MISSION

from pirate_sm.cli.commands import check, fresh_check
from pirate_sm.cli.options.checks import CheckOptions
from pirate_sm.cli.output.terminal import Show

from ..conftest import ROOT

WARNED = MISSION.replace("ends:", "  lost: {go: e}\nends:")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def warned(here: Path) -> Path:
    """A mission with a warning and nothing worse."""
    file = here / "m.yaml"
    file.write_text(WARNED, encoding="utf-8")
    return file


@pytest.fixture
def broken(here: Path) -> Path:
    """A mission with an error."""
    file = here / "b.yaml"
    file.write_text(WARNED.replace("ClampFront", "ClampFont"), encoding="utf-8")
    return file


@pytest.mark.thorough
def test_all_shipped_files_are_clean_even_of_warnings(
    pirate: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    result = pirate("check", "--fail-on", "warning")

    assert (result.exit_code, result.stderr) == (0, "")
    *allowed, last = result.stdout.splitlines()
    assert last.startswith(
        "2 robots, 2 charts, 32 pipes, 8 cameras, 1 panel, 44 missions, 3 experiments, 1 twin,"
        " 6 campaigns checked: "
    )
    # What the shipped missions allow is said, with the reason: an angle that jumps back.
    codes = {line.split()[1] for line in allowed if re.match(r"  \S+:\d+:\d+ ", line)}
    assert codes == {"handler.holding"}


def test_a_broken_mission_in_a_folder_that_is_no_project_is_no_false_green(
    pirate: Any, broken: Path
) -> None:
    """The shipped files were checked in its place."""
    result = pirate("check")

    assert result.exit_code == 1
    assert "mission.command" in result.stdout
    assert "\n1 mission checked in .: 1 error" in result.stdout


@pytest.mark.parametrize("paths", [(), ("empty",)])
def test_where_there_is_nothing_to_check_nothing_has_passed(
    pirate: Any, here: Path, paths: tuple[str, ...]
) -> None:
    (here / "empty").mkdir()
    result = pirate("check", *paths)

    assert result.exit_code == 2
    assert "there is no robot, mission, pipe or camera in this folder" in result.stdout


def test_a_finding_fails_the_check_from_its_severity_on(
    pirate: Any, warned: Path, broken: Path
) -> None:
    assert pirate("check", warned).exit_code == 0
    assert pirate("check", warned, "--fail-on", "warning").exit_code == 1
    result = pirate("check", broken)
    assert result.exit_code == 1
    assert "b.yaml:6:12: error [mission.command] there is no command 'ClampFont'" in result.stdout
    assert "did you mean 'ClampFront'?" in result.stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["nowhere.yaml"],
        ["m.yaml", "--robot", "pirate_3"],
        ["m.yaml", "--pipe", "straight_13"],
        ["m.yaml", "--set", "speed=1 m/s"],
        ["m.yaml", "--set", "speed"],
        ["m.yaml", "--format", "html"],
        ["m.yaml", "--fail-on", "never"],
        ["m.yaml", "--unsafe-fixes"],
    ],
)
def test_what_does_not_fit_is_refused(pirate: Any, warned: Path, arguments: list[str]) -> None:
    result = pirate("check", *arguments)

    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr


@pytest.fixture
def short(here: Path) -> Path:
    """A mission with an error of which nobody can doubt what was meant, and a misspelt phase."""
    file = here / "s.yaml"
    file.write_text(MISSION.replace("[ClampFront], go: e", "ClampFront, goo: e"), encoding="utf-8")
    return file


def test_what_is_sure_is_fixed_and_what_is_left_decides_the_exit_code(
    pirate: Any, short: Path
) -> None:
    assert "\n1 finding can be fixed by --fix\n1 finding can be" in pirate("check", short).stdout
    first = pirate("check", short, "--fix")
    assert (first.exit_code, "unknown-key" in first.stdout) == (1, True)
    assert "\n1 finding fixed\n1 finding can be fixed by a guess, with --fix" in first.stdout
    assert first.stdout.endswith(": 1 error\n")
    second = pirate("check", short, "--fix", "--unsafe-fixes")
    assert second.exit_code == 0
    assert second.stdout == "1 finding fixed\n1 mission checked in s.yaml: no findings\n"
    assert short.read_text("utf-8") == MISSION
    third = pirate("check", short, "--fix", "--format", "json")
    assert json.loads(third.stdout)["summary"]["fixed"] == 0


def test_what_a_fault_has_hidden_is_fixed_too(pirate: Any, here: Path) -> None:
    phase = "a: {wait: {when: speed >= 0 mm/s && phi => 2 deg, go: e}, within: {time: 5 s, go: e}}"
    text = MISSION.replace("a: {do: [ClampFront], go: e}", phase)
    (here / "s.yaml").write_text(text, encoding="utf-8")
    result = pirate("check", "s.yaml", "--fix")

    assert "\n3 findings fixed\n" in f"\n{result.stdout}"
    right = text.replace("&&", "and").replace("=>", ">=")
    assert (here / "s.yaml").read_text("utf-8") == right.replace("{when", "[{when").replace(
        "go: e}, within", "go: e}], within"
    )


def test_what_would_be_fixed_is_shown_and_nothing_changes(pirate: Any, short: Path) -> None:
    before = short.read_bytes()
    result = pirate("check", short, "--diff", "--unsafe-fixes")

    assert result.exit_code == 1
    assert result.stdout.startswith("--- s.yaml\n+++ s.yaml\n@@ ")
    assert "\n-  a: {do: ClampFront, goo: e}\n+  a: {do: [ClampFront], go: e}\n" in result.stdout
    assert short.read_bytes() == before
    short.write_text(MISSION, encoding="utf-8")
    nothing = pirate("check", short, "--diff")
    assert (nothing.exit_code, nothing.stdout) == (0, "")


def test_an_empty_folder_has_no_difference_either(pirate: Any, here: Path) -> None:
    result = pirate("check", here, "--diff")

    assert result.exit_code == 2
    assert result.stdout.endswith("nothing checked in .: 1 error\n")


def test_only_what_would_be_changed_can_be_fixed(pirate: Any, short: Path, here: Path) -> None:
    own = here / "own"
    own.mkdir()
    call = MISSION.replace("ClampFront", "{call: ../s.yaml}").replace("mission: m", "mission: n")
    (own / "n.yaml").write_text(call, encoding="utf-8")

    for result in (pirate("check", own), pirate("check", own, "--fix", "--unsafe-fixes")):
        assert "s.yaml:6:" in result.stdout
        assert "fixed" not in result.stdout
    assert "1 finding can be fixed by --fix\n" in pirate("check", here).stdout


@pytest.mark.parametrize(("more", "checks"), [((), 2), (("--counterexamples", "found"), 3)])
def test_files_are_not_checked_again_once_nothing_is_left_to_change(
    pirate: Any,
    short: Path,
    monkeypatch: pytest.MonkeyPatch,
    more: tuple[str, ...],
    checks: int,
) -> None:
    done, check_paths = [], fresh_check.check_paths

    def counted(*asked: Any) -> Any:
        done.append(asked)
        return check_paths(*asked)

    monkeypatch.setattr(fresh_check, "check_paths", counted)
    assert pirate("check", short, "--fix", "--unsafe-fixes", *more).exit_code == 0

    assert short.read_text("utf-8") == MISSION
    assert len(done) == checks


def test_another_robot_and_pipe_are_taken(pirate: Any, warned: Path) -> None:
    assert pirate("check", warned, "--pipe", "mitre_90", "--robot", "pirate_ii").exit_code == 0
    newt = ROOT / "tests" / "robots" / "newt"
    result = pirate("check", warned, "--robot", newt)
    assert result.exit_code == 1
    assert "there is no command 'ClampFront'" in result.stdout


@pytest.mark.parametrize(
    ("name", "begin"),
    [
        ("json", '{\n "format": 1'),
        ("sarif", '{\n "$schema": "'),
        ("junit", '<?xml version="1.0"'),
        ("github", "::error file=b.yaml,line=6,endLine=6,col=12,endColumn=21,title="),
    ],
)
def test_every_format_is_written_with_the_same_exit_code(
    pirate: Any, broken: Path, name: str, begin: str
) -> None:
    result = pirate("check", broken, "--format", name)

    assert result.exit_code == 1
    assert result.stdout.startswith(begin)


def test_a_terminal_is_coloured_and_nothing_else_is(
    capsys: pytest.CaptureFixture[str], broken: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = CheckOptions(paths=[str(broken)])
    check.run_check(options)
    assert "\x1b" not in "".join(capsys.readouterr())

    monkeypatch.setattr(check, "shows_colour", lambda _: True)
    check.run_check(options)
    assert "\x1b[1;91merror\x1b[0m" in capsys.readouterr().out


def test_a_terminal_shows_which_file_is_being_checked(
    broken: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines: list[str] = []

    @contextmanager
    def progress(what: str) -> Iterator[Show]:
        yield lambda share, more="": lines.append(f"{what}: {share:.0%}{more}")

    monkeypatch.setattr(fresh_check, "progress", progress)
    check.run_check(CheckOptions(paths=[str(broken)]))
    assert lines == ["checking: 0%, b.yaml"]


def test_text_of_a_file_cannot_control_the_terminal(pirate: Any, here: Path) -> None:
    name = "x\x1b]0;owned\x07.yaml"
    (here / name).write_text(WARNED.replace("ClampFront", '"\\e[2J"'), encoding="utf-8")

    for form in ("text", "json", "github", "sarif", "junit"):
        result = pirate("check", ".", "--format", form)
        assert result.exit_code == 1
        assert not {"\x1b", "\x07"} & set(result.output)


@pytest.mark.thorough
def test_a_name_that_is_no_text_is_shown_all_the_same(pirate: Any, here: Path) -> None:
    (here / b"m\xff.yaml".decode("utf-8", "surrogateescape")).write_text("mission: 1\nphases: 2\n")

    for form in ("text", "json", "github", "sarif", "junit"):
        result = pirate("check", ".", "--format", form)
        assert (result.exit_code, result.stderr) == (1, ""), form
        assert isinstance(result.exception, SystemExit), form
        result.stdout_bytes.decode("utf-8")

    code = "from pirate_sm.cli.entry import main; main()"
    ran = subprocess.run(
        [sys.executable, "-c", code, "check", "."],
        capture_output=True, check=False,
        env={"PYTHONPATH": str(ROOT), "PYTHONUTF8": "1", "PIRATE_SM_CACHE": ""},
    )  # fmt: skip
    assert (ran.returncode, ran.stderr) == (1, b"")
    ran.stdout.decode("utf-8")


def test_a_fault_of_the_check_is_a_finding_or_with_debug_a_traceback(
    pirate: Any, warned: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("lost")

    monkeypatch.setattr("pirate_sm.checking.check_file.check_mission", fail)

    result = pirate("check", warned)
    assert (result.exit_code, "check.failed" in result.stdout) == (1, True)
    result = pirate("check", warned, "--debug")
    assert (result.exit_code, "Traceback" in result.stderr) == (4, True)


def test_a_code_is_explained(pirate: Any) -> None:
    result = pirate("explain", "trigger.at_once")

    assert result.exit_code == 0
    assert "Why it matters: The wait waits for nothing." in result.stdout


def test_a_misspelt_code_is_understood(pirate: Any) -> None:
    result = pirate("explain", "trigger.at_one")
    assert result.exit_code == 2
    assert "did you mean 'trigger.at_once'?" in result.stderr
    assert "lists them all" in pirate("explain", "quite different").stderr


def test_a_control_is_explained_with_what_it_extends(pirate: Any) -> None:
    result = pirate("explain", "exp_3d")

    assert result.exit_code == 0
    assert "It extends exp_3c, which extends exp_3a." in result.stdout
    assert "BendingState.DoubleClamped: gamma_1 bears -350 mNm" in result.stdout
    assert "also bear the weight" in result.stdout
    assert "friction 0.2 (front), 0.5 (rear), safety 2" in result.stdout


def test_a_control_of_a_robot_of_ones_own_is_explained(pirate: Any, tmp_path: Path) -> None:
    robot = tmp_path / "mine"
    shutil.copytree(ROOT / "hardware_profiles" / "pirate_ii", robot)
    profile = robot / "profile.yaml"
    text = profile.read_text(encoding="utf-8")
    mine = "controls:\n  bare: {gravity_compensation: false}\n"
    profile.write_text(text.replace("controls:\n", mine, 1), encoding="utf-8")

    assert pirate("explain", "bare").exit_code == 2
    told = pirate("explain", "bare", "--robot", robot)
    assert told.exit_code == 0
    assert "bare (control of pirate_ii)" in told.stdout
    assert "did you mean 'bare'?" in pirate("explain", "bear", "--robot", robot).stderr


def test_without_a_code_all_are_listed(pirate: Any) -> None:
    result = pirate("explain")

    assert result.exit_code == 0
    for code in ("step.impossible", "chart.trap", "geometry.too_close", "unknown-key"):
        assert f"  {code} " in result.stdout


def test_json_is_one_object(pirate: Any, broken: Path) -> None:
    data = json.loads(pirate("check", broken, "--format", "json").stdout)

    assert data["files"] == [{"file": "b.yaml", "kind": "mission"}]


def test_a_campaign_is_checked_as_it_would_be_run(pirate: Any, tmp_path: Path) -> None:
    file = tmp_path / "trial.yaml"
    file.write_text(
        "format: 1\ncampaign: trial\n"
        "missions:\n"
        "- mitre_bent\n"
        "- {mission: mitre_bend, pipe: straight_113}\n"
        "- {mission: drive_on, defects: [gamma_2_drop]}\n"
        "seeds: 5\n",
        encoding="utf-8",
    )
    result = pirate("check", str(file))

    assert result.exit_code == 1
    assert (
        "trial.yaml:4:3: error [campaign.mission] there is no mission 'mitre_bent'" in result.stdout
    )
    assert "trial.yaml:6:33: error [campaign.defect] there is no defect" in result.stdout
    assert "trial.yaml:5:3: error [geometry.no_bend] with these choices" in result.stdout
    assert "mitre_bend.yaml:38:" in result.stdout
    assert "1 campaign checked" in result.stdout


def test_a_campaign_leads_out_of_the_project_only_if_wanted(
    pirate: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside = tmp_path / "project"
    (inside / ".git").mkdir(parents=True)
    monkeypatch.chdir(inside)
    (tmp_path / "secret.yaml").write_text("password: 1234\n", encoding="utf-8")
    file = inside / "trial.yaml"
    text = "format: 1\ncampaign: trial\nmissions: [../secret.yaml]\nseeds: 5\n"
    file.write_text(text, encoding="utf-8")

    assert "trial.yaml:3:12: error [reference.outside]" in pirate("check", str(file)).stdout
    result = pirate("check", "--outside", str(file))
    assert "this leads to a file that is no mission" in result.stdout
    assert "1234" not in result.stdout


def test_experiments_and_twins_are_checked_with_their_robot(pirate: Any, tmp_path: Path) -> None:
    robot = tmp_path / "hardware_profiles" / "pirate_ii"
    shutil.copytree(ROOT / "hardware_profiles" / "pirate_ii", robot)
    experiment = robot / "experiments" / "experiment_1.yaml"
    text = experiment.read_text(encoding="utf-8")
    experiment.write_text(text.replace("exp_1a_both", "exp_1a_bth"), encoding="utf-8")
    twin = tmp_path / "twin.yaml"
    twin.write_text(
        "format: 1\nrobot: pirate_ii\nmotors:\n  wheels: {stall_torque: 0.3 Nm}\n"
        "  bend: {hold_torque: 0.1 Nm}\n",
        encoding="utf-8",
    )

    result = pirate("check", robot, twin)

    assert result.exit_code == 1
    assert "experiment_1.yaml:10:16: error [experiment.name] there is no mission" in result.stdout
    assert "did you mean 'exp_1a_both'" in result.stdout
    assert "twin.yaml:4:3: error [twin.motor] there is no kind of motor 'wheels'" in result.stdout
    assert "twin.yaml:5:23: error [twin.motor]" in result.stdout
    assert "1 robot, 1 chart, 3 experiments, 1 twin checked" in result.stdout


@pytest.mark.thorough
def test_scenes_are_checked(pirate: Any, tmp_path: Path) -> None:
    scene = tmp_path / "stiff.yaml"
    scene.write_text(
        "format: 1\nscene: soft\ntitle: A stiff joint\nlook_at: The joint\n"
        "steps:\n  - command: run mitre_bend --record {oout}/run.mcap\n"
        "  - {command: run climb, expect: {ended: succeeded}}\n"
        "  - command: run 'climb\n",
        encoding="utf-8",
    )

    result = pirate("check", scene)

    assert result.exit_code == 1
    assert "stiff.yaml:2:8: error [scene.name]" in result.stdout
    assert "stiff.yaml:6:14: error [scene.folder]" in result.stdout
    assert "stiff.yaml:7:15: error [scene.record]" in result.stdout
    assert "stiff.yaml:8:14: error [scene.command]" in result.stdout
    assert "1 scene checked" in result.stdout
    assert pirate("check", *(ROOT / "demos").glob("*.yaml")).exit_code == 0


def test_a_twin_of_no_robot_is_reported(pirate: Any, tmp_path: Path) -> None:
    twin = tmp_path / "twin.yaml"
    twin.write_text("format: 1\nrobot: pirate_i\nmotors: {}\n", encoding="utf-8")

    assert "[twin.robot] there is no robot 'pirate_i'" in pirate("check", twin).stdout
