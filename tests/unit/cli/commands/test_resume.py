"""`pirate run --resume`, as a person without a terminal meets it, with a simulated robot."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from click.testing import Result
from representative import thorough_but
from typer.testing import CliRunner

from benchmarks.resume_rides import LIES, World, _Grip, prepared_on, ride_on, world
from pirate_sm.cli.commands.resume import ResumeDialog, _Wishes
from pirate_sm.cli.entry import commands, only_run
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.detectors.registry import Detecting
from pirate_sm.running.recording.format.header import CHECKPOINT
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.write import recorder
from pirate_sm.running.runtime.ending import StopRequests
from pirate_sm.running.wiring import Order, placed
from pirate_sm.running.wiring.resume_offer import Said, end_of_run
from pirate_sm.running.wiring.resumed_run import first_wheel_m
from tests.unit.running.recording.recording_runs import record_cut_off

from ..terminals import on_a_terminal, once

ROOT = Path(__file__).parents[4]
CUT_S = 16.0


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
    return CliRunner().invoke(only_run(), ["--resume", *map(str, options)])


def test_a_look_says_where_it_was_and_what_is_seen(cut: Path) -> None:
    result = resume(cut, "--look")

    assert result.exit_code == 0
    assert "mitre_bend on sim" in result.stdout
    assert f"cut off at {CUT_S:.1f}"[:-2] in result.stdout
    assert "confirmed    front holds" in result.stdout
    assert "next: " in result.stdout
    assert result.stdout.endswith("can continue\n")


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
    assert "it can continue: agree to it on a terminal, or with --accept" in result.stderr


def test_options_that_the_recording_has_are_refused_all_at_once(cut: Path) -> None:
    result = resume(cut, "mitre_bend", "--set", "a=1", "--pipe", "mitre_90")

    assert result.exit_code == 2
    assert "leave out: --pipe, --set, a mission" in result.stderr


@pytest.mark.parametrize("option", ["--look", "--accept", "--at=pass"])
def test_its_options_need_a_recording(option: str) -> None:
    result = CliRunner().invoke(only_run(), ["mitre_bend", option])

    assert result.exit_code == 2
    assert f"{option.partition('=')[0]}: only together with --resume" in result.stderr


@pytest.mark.thorough
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


def repaired_after_damage(piece: int, *, end_too: bool = False) -> tuple[Path, Recording]:
    """A run that was cut off, with a wrong bit in this piece, and one near its end, repaired."""
    cut = Path("cut.mcap")
    record_cut_off(cut, Order("mitre_bend"), CUT_S, 1.0)
    damaged = bytearray(cut.read_bytes())
    damaged[read_recording(cut).content.pieces[piece].at + 100] ^= 1
    if end_too:
        damaged[damaged.rindex(CHECKPOINT.encode()) - 1] ^= 0x40  # the length of its name
    cut.write_bytes(damaged)
    again = Path("again.mcap")
    assert CliRunner().invoke(commands, ["repair", str(cut), "-o", str(again)]).exit_code == 0
    return again, read_recording(again)


def test_a_recording_with_damage_that_no_checkpoint_follows_is_not_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    repaired_after_damage(-2)

    result = resume("again.mcap", "--accept")

    assert result.exit_code == 2
    assert "cannot resume: again.mcap was damaged from" in result.stderr
    assert "so what the mission knew at its end is unknown" in result.stderr


@pytest.mark.parametrize("end_too", thorough_but([True], [False, True]))
def test_a_recording_with_damage_before_a_checkpoint_is_asked_about(
    end_too: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(recorder, "CHECKPOINT_S", 2.0)
    again, recording = repaired_after_damage(1, end_too=end_too)
    ((_, from_s, until_s),) = recording.gaps
    assert recording.checkpoint(recording.until_s) is not None

    refused = resume(again, "--accept")
    looked = resume(again, "--look")

    assert refused.exit_code == 2
    end = f" and after {recording.until_s:.3f} s" if end_too else ""
    assert (
        "--accept is not enough: the recording was damaged and has been repaired: what the robot "
        f"did from {from_s:.3f} s to {until_s:.3f} s{end} is unknown"
    ) in refused.stderr
    assert looked.exit_code == 0, looked.stderr


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
    result = CliRunner().invoke(only_run(), [])

    assert result.exit_code == 2
    assert "name a MISSION, or a recording with --resume" in result.stderr


@pytest.mark.thorough
def test_a_run_that_was_resumed_can_be_resumed_again(
    cut: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "_HELP_AT", 10)
    monkeypatch.setattr(recorder, "_MOST_STEPS", 20)
    resume(cut, "--accept", "--quiet", "--speed", "max", "--record", "on.mcap")
    whole = Path("on.mcap").read_bytes()
    pieces = read_recording(Path("on.mcap")).content.pieces
    again = Path("again.mcap")
    again.write_bytes(whole[: pieces[len(pieces) // 4].at - 9])

    result = resume(again, "--accept", "--quiet", "--speed", "max", "--record", "end.mcap")

    assert len(pieces) > 1
    assert result.exit_code == 0, result.stderr
    chain = read_recording(Path("end.mcap")).header.resumed
    assert [each.name for each in chain] == ["cut.mcap", "again.mcap"]


@pytest.mark.parametrize(
    ("mission", "cut_s"),
    thorough_but(
        [("enter_3d", 20.3)],
        [
            ("take_elbow", 5.0),
            ("house_connection", 60.0),
            # In a plane, where both parts have turned.
            ("enter_3d", 10.0),
            ("enter_3d", 20.3),
        ],
    ),
)
def test_a_simulated_robot_is_put_back_and_goes_on_to_the_same_end(
    mission: str, cut_s: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    record_cut_off(Path("cut.mcap"), Order(mission), cut_s)

    result = resume("cut.mcap", "--accept", "--plain", "--speed", "max", "--no-record")

    assert result.exit_code == 0, result.stderr
    assert "succeeded" in result.stdout


@pytest.mark.thorough
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


@pytest.mark.parametrize(
    ("key", "code"), thorough_but([("\r", 2)], [("\x03", 130), ("\r", 2), ("\x04", 2)])
)
def test_a_person_leaves_the_robot_as_it_is(cut: Path, key: str, code: int) -> None:
    ended, shown, same = on_a_terminal(
        ("--resume", str(cut.resolve()), "--no-record"), once("leave [enter]? ", key)
    )

    assert (ended, same) == (code, True)
    assert "nothing has moved" in shown
    assert "Traceback" not in shown


@pytest.mark.thorough
def test_a_person_agrees(cut: Path) -> None:
    options = ("--resume", str(cut.resolve()), "--no-record", "--plain", "--speed", "max")
    ended, shown, _ = on_a_terminal(options, once("leave [enter]? ", "g\r"))

    assert ended == 0
    assert "succeeded" in shown


@pytest.mark.thorough
def test_a_person_can_regrip_although_the_mission_fails_after_it(cut: Path) -> None:
    options = ("--resume", str(cut.resolve()), "--no-record", "--plain", "--speed", "max")
    ended, shown, _ = on_a_terminal(options, once("leave [enter]? ", "r\r"))

    assert "expected: fails: no path leads to an end that succeeds" in shown
    assert ended == 1
    assert "failed after" in shown


@pytest.mark.thorough
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


# --- a robot on a link, asked about for as long as it takes -----------------------------------


class Operator:
    """Thinks before each answer, while the backend serves the link."""

    def __init__(
        self,
        backend: SerialBackend,
        answers: Sequence[str | Callable[[], str]],
        thinks_s: float,
    ) -> None:
        self.backend, self.left, self.thinks_s = backend, list(answers), thinks_s

    def __call__(self, check: Callable[[], None]) -> str:
        until_s = self.backend.port.now() + self.thinks_s
        while self.backend.port.now() < until_s:
            self.backend.tend()
        answer = self.left.pop(0)
        return answer if isinstance(answer, str) else answer()


class Cut(NamedTuple):
    """A mission on the emulated bay whose program was killed while the wheels drove."""

    it: World
    path: Path

    def dialog(self, detector: str, **said: Any) -> ResumeDialog:
        prepared = prepared_on(self.it, self.it.port.next_port())
        if detector == "odometry":
            found = Detecting("odometry", prepared.companions[1:2])
            counting = replace(prepared, usual_detector="odometry", detecting=found)
            prepared = placed(counting, 0.7)
        dialog = ResumeDialog(
            prepared, end_of_run(self.path), Said(**said), _Wishes(), StopRequests()
        )
        dialog._dark_s = 10.0
        return dialog


@pytest.fixture
def operator(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Operator]:
    def answering(
        dialog: ResumeDialog, *answers: str | Callable[[], str], thinks_s: float = 1.0
    ) -> Operator:
        backend = dialog.prepared.backend
        assert isinstance(backend, SerialBackend)
        someone = Operator(backend, answers, thinks_s)
        monkeypatch.setattr("pirate_sm.cli.commands.resume.answered_line", someone)
        for stream in (sys.stdin, sys.stderr):
            monkeypatch.setattr(stream, "isatty", lambda: True)
        return someone

    return answering


def cut_on_a_link(path: Path, mission: str, until_s: float) -> Cut:
    it = world(mission, 0)
    ride_on(prepared_on(it, it.port), _Grip(it.loaded, it.bay), until_s, path)
    it.port.die(it.port.now() + 1.0)
    return Cut(it, path)


@pytest.mark.thorough
def test_belief_an_operator_may_think_before_a_mission_resumes(
    tmp_path: Path, operator: Callable[..., Operator]
) -> None:
    """It was `link.silent` after 14 s, and both clamps were not confirmed."""
    cut = cut_on_a_link(tmp_path / "cut.mcap", "mitre_bend", 21.0)
    dialog = cut.dialog("sim")
    operator(dialog, "l", "g", thinks_s=20.0)
    chosen = dialog.decide()
    assert chosen is not None
    after, _ = ride_on(chosen[0], _Grip(cut.it.loaded, cut.it.bay), resuming=chosen[1])

    assert (after.outcome, after.loose) == ("succeeded", frozenset())


@pytest.mark.parametrize(
    ("mission", "until_s", "detector", "why"),
    thorough_but(
        [("drive_on", 2.5, "sim", "the position: the mission reads it")],
        [
            ("mitre_bend", 21.0, "odometry", "where the detector odometry counts from"),
            ("drive_on", 2.5, "sim", "the position: the mission reads it"),
        ],
    ),
)
def test_belief_an_unknown_place_is_not_passed_over_by_a_key(
    mission: str,
    until_s: float,
    detector: str,
    why: str,
    tmp_path: Path,
    operator: Callable[..., Operator],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The robot bent, because the detector had counted from a place that nobody knew."""
    cut = cut_on_a_link(tmp_path / "cut.mcap", mission, until_s)
    cut.it.bay.robot.electronics.restart()  # its counters are lost
    dialog = cut.dialog(detector)
    where = f"{cut.it.bay.truth.arcs_m[0]:.3f} m"
    someone = operator(dialog, "g", "99 m", "g", "nowhere", "g", "", "g", where, "g")
    chosen = dialog.decide()
    shown = capsys.readouterr()

    assert chosen is not None
    assert someone.left == []
    assert f"unknown: {why}" in shown.out
    assert "can continue once you say where the robot is\n" in shown.out
    assert shown.out.endswith("can continue\n")
    assert "the pipe goes from 0 to" in shown.err
    assert "nowhere" in shown.err
    if detector == "odometry":
        assert f"{cut.it.bay.truth.arcs_m[0] * 1000:.0f}" in chosen[0].notices[-1]
    else:
        assert not chosen[1].resumption.adrift


def test_a_robot_that_has_changed_while_somebody_thought_is_shown_again(
    tmp_path: Path, operator: Callable[..., Operator], capsys: pytest.CaptureFixture[str]
) -> None:
    cut = cut_on_a_link(tmp_path / "cut.mcap", "mitre_bend", 21.0)
    dialog = cut.dialog("sim")

    def pushed() -> str:
        LIES["moved by hand"](cut.it, cut.path)
        return "g"

    operator(dialog, pushed, "")

    assert dialog.decide() is None
    assert "the robot has changed since that was shown" in capsys.readouterr().err


def test_belief_a_detector_counts_from_where_the_robot_has_rolled_in_the_dark(
    tmp_path: Path, operator: Callable[..., Operator]
) -> None:
    """It counted from where the recording ends, although the wheels show where the robot is."""
    cut = cut_on_a_link(tmp_path / "cut.mcap", "mitre_bend", 21.0)
    dialog = cut.dialog("odometry")
    operator(dialog, "g")
    chosen = dialog.decide()

    assert chosen is not None
    counted_m = chosen[0].order.start_at_m
    assert counted_m == pytest.approx(cut.it.bay.truth.arcs_m[0], abs=0.01)
    was_m = first_wheel_m(end_of_run(cut.path))
    assert counted_m is not None
    assert was_m is not None
    assert counted_m > was_m + 0.005
