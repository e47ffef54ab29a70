"""`pirate run --resume`, as a person without a terminal meets it, with a simulated robot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from typer.testing import CliRunner

from pirate_sm.cli.entry import commands, only_run
from pirate_sm.recording.read.reader import read_recording
from pirate_sm.recording.write import recorder
from pirate_sm.wiring import Order
from tests.unit.recording.recording_runs import record_cut_off

from ..terminals import on_a_terminal, once

ROOT = Path(__file__).parents[4]
CUT_S = 6.0


@pytest.fixture(scope="module")
def cut_off(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A drive through a pipe, cut off while the wheels drive."""
    path = tmp_path_factory.mktemp("runs") / "cut.mcap"
    record_cut_off(path, Order("mitre_bend"), CUT_S)
    return path.read_bytes()


@pytest.fixture
def cut(cut_off: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = Path("cut.mcap")
    path.write_bytes(cut_off)
    return path


def resume(*options: object) -> Result:
    return CliRunner().invoke(only_run, ["--resume", *map(str, options)])


def test_a_look_says_where_it_was_and_what_is_seen(cut: Path) -> None:
    result = resume(cut, "--look")

    assert result.exit_code == 0
    assert "mitre_bend on sim" in result.stdout
    assert f"cut off at {CUT_S:.1f}"[:-2] in result.stdout
    assert "confirmed    front holds" in result.stdout
    assert "next: " in result.stdout
    assert result.stdout.endswith("can go on\n")


def test_it_goes_on_to_the_same_end_and_its_recording_names_the_one_before(
    cut: Path, pirate: Callable[..., Any]
) -> None:
    result = resume(cut, "--accept", "--plain", "--speed", "max", "--record", "on.mcap")

    assert result.exit_code == 0
    assert "succeeded" in result.stdout
    (before,) = read_recording(Path("on.mcap")).header.resumed
    assert before.name == cut.name
    assert before.sha256 == read_recording(cut).sha256
    assert pirate("replay", "on.mcap").exit_code == 0


def test_nobody_agrees_without_a_terminal(cut: Path) -> None:
    result = resume(cut)

    assert result.exit_code == 2
    assert "it can go on: agree to it on a terminal, or with --accept" in result.stderr


def test_options_that_the_recording_has_are_refused_all_at_once(cut: Path) -> None:
    result = resume(cut, "mitre_bend", "--set", "a=1", "--pipe", "mitre_90")

    assert result.exit_code == 2
    assert "leave out: a mission, --pipe, --set" in result.stderr


@pytest.mark.parametrize("option", ["--look", "--accept", "--at=pass"])
def test_its_options_need_a_recording(option: str) -> None:
    result = CliRunner().invoke(only_run, ["mitre_bend", option])

    assert result.exit_code == 2
    assert f"{option.partition('=')[0]}: only together with --resume" in result.stderr


@pytest.mark.parametrize("more", ["# a word more\n", "- no YAML: [\n"])
def test_a_mission_that_was_edited_since_is_asked_about(
    more: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    mission = tmp_path / "mine.yaml"
    shipped = (ROOT / "sequences/enter_2d.yaml").read_text("utf-8")
    mission.write_text(shipped, "utf-8")
    record_cut_off(Path("cut.mcap"), Order(str(mission)), 2.0)
    assert resume("cut.mcap", "--look").exit_code == 0
    mission.write_text(shipped + more, "utf-8")

    edited = resume("cut.mcap", "--accept")
    mission.unlink()
    gone = resume("cut.mcap", "--accept", "--speed", "max", "--no-record")

    assert (edited.exit_code, gone.exit_code) == (2, 0)
    assert "--accept is not enough: " in edited.stderr
    assert "mine.yaml has changed since; the mission of the recording counts" in edited.stderr
    assert "mine.yaml is not there any more; the mission of the recording counts" in gone.stderr


def test_a_recording_that_was_damaged_and_repaired_is_asked_about(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    cut = Path("cut.mcap")
    record_cut_off(cut, Order("mitre_bend"), CUT_S, 1.0)
    damaged = bytearray(cut.read_bytes())
    damaged[read_recording(cut).content.pieces[-2].at + 100] ^= 1
    cut.write_bytes(damaged)
    assert CliRunner().invoke(commands, ["repair", str(cut), "-o", "again.mcap"]).exit_code == 0

    result = resume("again.mcap", "--accept")

    assert result.exit_code == 2
    assert "--accept is not enough: the recording was damaged at byte" in result.stderr
    assert "what the robot did after" in result.stderr


def test_a_recording_that_was_only_cut_off_and_repaired_is_resumed_as_before(cut: Path) -> None:
    assert CliRunner().invoke(commands, ["repair", str(cut), "-o", "again.mcap"]).exit_code == 0

    assert resume("again.mcap", "--accept", "--speed", "max", "--no-record").exit_code == 0


def test_a_phase_and_states_must_exist_which_is_said_before_anything_is_looked_at(
    cut: Path,
) -> None:
    result = resume(
        cut, "--at", "hlt", "--state", "FrontWheelState=Fixed", "--state", "BendingState=Reer"
    )

    assert (result.exit_code, result.stdout) == (2, "")
    phase, region, state = result.stderr.splitlines()
    assert phase == "--at: the mission has no phase 'hlt': did you mean 'halt'?"
    assert region.startswith("--state: no region 'FrontWheelState': did you mean ")
    assert state.startswith("--state: BendingState has no state 'Reer': ")


def test_what_is_said_against_the_sensors_does_not_help(cut: Path) -> None:
    result = resume(cut, "--state", "BendingState=DoubleClamped", "--look")

    assert "said: BendingState is DoubleClamped" in result.stdout
    assert "confirmed    rear holds" not in result.stdout


def test_a_file_that_is_no_recording(tmp_path: Path) -> None:
    path = tmp_path / "none.mcap"
    path.write_text("nothing")

    result = resume(path, "--look")

    assert result.exit_code == 2
    assert "is not a recording" in result.stderr


def test_neither_a_mission_nor_a_recording() -> None:
    result = CliRunner().invoke(only_run, [])

    assert result.exit_code == 2
    assert "name a MISSION, or a recording with --resume" in result.stderr


def test_a_run_that_was_resumed_can_be_resumed_again(
    cut: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "_HELP_AT", 10)
    monkeypatch.setattr(recorder, "_MOST_STEPS", 20)
    resume(cut, "--accept", "--quiet", "--speed", "max", "--record", "on.mcap")
    whole = Path("on.mcap").read_bytes()
    pieces = read_recording(Path("on.mcap")).content.pieces
    again = Path("again.mcap")
    again.write_bytes(whole[: pieces[len(pieces) // 3].at - 9])

    result = resume(again, "--accept", "--quiet", "--speed", "max", "--record", "end.mcap")

    assert len(pieces) > 1
    assert result.exit_code == 0, result.stderr
    chain = read_recording(Path("end.mcap")).header.resumed
    assert [each.name for each in chain] == ["cut.mcap", "again.mcap"]


@pytest.mark.parametrize(
    ("mission", "cut_s"),
    [
        ("take_elbow", 5.0),
        ("house_connection", 30.0),
        # In a plane, where both parts have turned.
        ("enter_3d", 10.0),
        ("enter_3d", 20.3),
    ],
)
def test_a_simulated_robot_is_put_back_and_goes_on_to_the_same_end(
    mission: str, cut_s: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    record_cut_off(Path("cut.mcap"), Order(mission), cut_s)

    result = resume("cut.mcap", "--accept", "--plain", "--speed", "max", "--no-record")

    assert result.exit_code == 0, result.stderr
    assert "succeeded" in result.stdout


def test_nobody_is_asked_about_a_robot_that_extends_another_and_has_not_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    record_cut_off(Path("cut.mcap"), Order("level"), 6.5)

    result = resume("cut.mcap", "--look")

    assert "has changed since" not in result.stdout + result.stderr


def test_a_robot_of_another_physics_is_not_put_back_in_a_round_pipe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    record_cut_off(Path("cut.mcap"), Order("turn_left", backend="physics"), 2.0)

    result = resume("cut.mcap", "--look")

    assert result.exit_code == 2
    assert "a robot of the backend physics cannot be put back in a round pipe" in result.stderr


@pytest.mark.parametrize(("key", "code"), [("\x03", 130), ("\r", 2), ("\x04", 2)])
def test_a_person_leaves_the_robot_as_it_is(cut: Path, key: str, code: int) -> None:
    ended, shown, same = on_a_terminal(
        ("--resume", str(cut.resolve()), "--no-record"), once("leave [enter]? ", key)
    )

    assert (ended, same) == (code, True)
    assert "nothing has moved" in shown
    assert "Traceback" not in shown


def test_a_person_agrees(cut: Path) -> None:
    options = ("--resume", str(cut.resolve()), "--no-record", "--plain", "--speed", "max")
    ended, shown, _ = on_a_terminal(options, once("leave [enter]? ", "g\r"))

    assert ended == 0
    assert "succeeded" in shown


def test_a_person_can_regrip_although_the_mission_fails_after_it(cut: Path) -> None:
    options = ("--resume", str(cut.resolve()), "--no-record", "--plain", "--speed", "max")
    ended, shown, _ = on_a_terminal(options, once("leave [enter]? ", "r\r"))

    assert "expected: fails: no path leads to an end that succeeds" in shown
    assert ended == 1
    assert "failed after" in shown


def test_why_nobody_can_regrip_stays_to_be_read(tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    record_cut_off(path, Order("turn_left"), 1.0)

    keys = ["\r", "r\r"]
    options = ("--resume", str(path), "--no-record")
    ended, shown, _ = on_a_terminal(
        options,
        lambda text: keys.pop() if text.count("leave [enter]? ") > 2 - len(keys) else "",
    )

    assert ended == 2
    reason = shown.index("no `on_failure` handles a failure in")
    assert shown.count("cut off at", reason) == 0


@pytest.mark.parametrize("place", ["-3 m", "99 m"])
def test_a_wheel_outside_the_pipe_is_not_believed(cut: Path, place: str) -> None:
    result = resume(cut, "--look", f"--start-at={place}")

    assert result.exit_code == 2
    assert "the pipe goes from 0 to" in result.stderr
