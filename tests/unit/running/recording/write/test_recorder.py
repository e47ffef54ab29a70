"""What is told to a recorder is in the file, and nothing that breaks there reaches the run."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from keeping import Memory, Told, course, header, mission, recorder, tell

from pirate_sm.core.effects import Ended, Setpoints, WakeAt
from pirate_sm.core.engine import Engine
from pirate_sm.core.events import Event, SensorFrame, SignalReport, Tick
from pirate_sm.core.resuming import Beginning
from pirate_sm.core.robot import Mark, RobotState, at_rest_in
from pirate_sm.running.recording.format.json_values import body_from_text, body_to_text
from pirate_sm.running.recording.read.pieces import RecordedStep
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.viewers.viewer_messages import ViewerMessages
from pirate_sm.running.recording.write import recorder as module
from pirate_sm.running.recording.write.recorder import AHEAD_S, Recorder
from pirate_sm.running.recording.write.recording_file import DiskFile, RecordingFile
from pirate_sm.running.recording.write.sampler import SideChannel
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare


def read(memory: Memory, folder: Path) -> Recording:
    path = folder / "run.mcap"
    path.write_bytes(memory.data)
    return read_recording(path)


def test_everything_is_kept_in_order(tmp_path: Path) -> None:
    memory, told = Memory(), course(5_000)
    one = recorder(memory)
    tell(one, told)
    one.abandon(99.0, (Setpoints(7, (0.0,) * 18), Ended("interrupted", "stopped")))
    one.close()

    recording = read(memory, tmp_path)
    steps = list(recording.steps())

    assert one.failure == ""
    assert memory.closed
    assert recording.complete
    assert recording.notices == ()
    assert [step.number for step in steps] == list(range(len(told) + 2))
    assert steps[0] == RecordedStep(0, 0.0, None, (WakeAt(0.5),), "start")
    assert [(step.event, step.at_s, step.effects) for step in steps[1:-1]] == told
    assert {step.by for step in steps[1:-1]} == {"engine"}
    assert steps[-1].by == "runtime"
    assert steps[-1].effects[-1] == Ended("interrupted", "stopped")


def test_what_the_engine_was_shown_before_its_start_is_told_apart(tmp_path: Path) -> None:
    memory = Memory()
    seen: list[Event] = [SensorFrame(23, (1.0,) * 6), SignalReport((("a", 1.0),), (("b", None),))]
    one = recorder(memory)
    one.start(seen, 0.0, ())
    one.take(Tick(), 0.5, ())
    one.close()

    steps = list(read(memory, tmp_path).steps())

    assert [step.by for step in steps] == ["seen", "seen", "start", "engine"]
    assert [step.event for step in steps[:2]] == seen


def test_a_start_where_another_mission_ended_is_kept_whole(tmp_path: Path) -> None:
    memory = Memory()
    body = RobotState(
        3, (float("nan"), 0.25), frozenset({Mark("part", 0, 4), Mark("region", 2, 1)}), 17,
        seeking=frozenset({4, 2}), sent=True,
    )  # fmt: skip
    one = recorder(memory)
    one.start((), 12.5, (), Beginning(body, paused=True))
    one.close()

    (step,) = read(memory, tmp_path).steps()

    assert step.paused
    assert step.body is not None
    assert step.body.values[1:] == (0.25,)
    assert step.body._replace(values=()) == body._replace(values=())


def test_the_texts_are_kept_with_their_hashes(tmp_path: Path) -> None:
    memory = Memory()
    recorder(memory).close()

    found = read(memory, tmp_path).header

    assert found == header()
    assert [file.role for file in found.files][:3] == ["mission", "profile", "chart"]
    assert found.files[0].path == "shipped:sequences/mitre_bend.yaml"
    assert {file.text for file in found.files} == {each.text for each in mission().documents}


def tell_to_the_disk(one: Recorder, told: list[Told]) -> None:
    """All of this is in the file, as one piece."""
    tell(one, told)
    one.ahead_s = 60.0
    one.secure()


@pytest.mark.parametrize("room_for_more", [0, 1, 20_000])
def test_a_full_disk_ends_the_recording_and_keeps_what_was_there(
    tmp_path: Path, room_for_more: int
) -> None:
    roomy, told = Memory(), course(100)
    tell_to_the_disk(recorder(roomy), told)
    memory = Memory(room=len(roomy.data) + room_for_more)
    one = recorder(memory)
    tell_to_the_disk(one, told)
    one.ahead_s = AHEAD_S
    while not one.failure:
        one.take(Tick(), 2.0, (WakeAt(3.0),) * 50)
        one.secure()
    one.take(Tick(), 3.0, ())
    one.close()

    recording = read(memory, tmp_path)
    steps = list(recording.steps())

    assert one.failure == "No space left on device"
    assert one.kept_s == recording.until_s == steps[-1].at_s
    assert not recording.complete
    assert len(recording.notices) == 1
    assert [(step.event, step.at_s, step.effects) for step in steps[1:102]] == told


def test_a_disk_too_small_for_the_first_piece_keeps_what_is_needed_to_name_the_run(
    tmp_path: Path,
) -> None:
    empty = Memory()
    recorder(empty)
    memory = Memory(room=len(empty.data) + 1)
    one = recorder(memory)
    tell(one, course(100))
    one.close()

    recording = read(memory, tmp_path)

    assert one.failure == "No space left on device"
    assert one.kept_s is None
    assert list(recording.steps()) == []
    assert not recording.complete
    assert recording.header == header()


def test_a_disk_full_from_the_beginning_is_told_at_once() -> None:
    begun = header()

    with pytest.raises(OSError, match="No space left"):
        RecordingFile(Memory(room=100), begun)


def test_a_run_with_a_robot_never_waits_for_a_disk_that_hangs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "_MOST_WAITING", 100)
    monkeypatch.setattr(module, "_PATIENCE_S", 0.0)
    hang, begun = threading.Event(), threading.Event()
    memory = Memory()
    one = recorder(memory, real_time=True, commit_s=0.0)
    begun.wait(0)
    memory._wait = lambda: (begun.set(), hang.wait())  # type: ignore[assignment, func-returns-value]
    one.start((), 0.0, ())
    begun.wait()
    for event, at_s, effects in course(200):
        one.take(event, at_s, effects)
    one.close()
    hang.set()

    assert one.failure == "the disk is too slow"


def test_a_run_without_a_robot_makes_bytes_itself_when_it_is_ahead(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_HELP_AT", 10)
    monkeypatch.setattr(module, "_MOST_STEPS", 25)
    memory, told = Memory(), course(300)
    one = recorder(memory)
    tell(one, told)

    assert one._gathered.steps <= 10
    one.close()
    steps = list(read(memory, tmp_path).steps())
    assert [(step.event, step.at_s, step.effects) for step in steps[1:]] == told


def test_bytes_do_not_pile_up_before_a_disk_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_HELP_AT", 10)
    monkeypatch.setattr(module, "_MOST_STEPS", 25)
    monkeypatch.setattr(module, "_MOST_BYTES", 5_000)
    monkeypatch.setattr(module, "_PATIENCE_S", 0.0)
    hang = threading.Event()
    memory = Memory()
    one = recorder(memory)
    memory._wait = lambda: hang.wait() and None  # type: ignore[func-returns-value]
    tell(one, course(5_000))
    hang.set()
    one.close()

    assert one.failure == "the disk is too slow"


def test_pieces_may_be_written_while_it_is_counted_how_many_bytes_wait() -> None:
    """A mission ended with an internal error: the thread had written one at this moment."""

    class Written:
        @property
        def data(self) -> bytes:
            one._unwritten.clear()
            return b""

    one = recorder(Memory())
    one._unwritten.extend([Written(), Written()])  # type: ignore[list-item]
    one._lend_a_hand(ends=False)
    one.close()

    assert not one.failure


def test_a_fault_in_making_bytes_ends_the_recording_only() -> None:
    one = recorder(Memory())
    one.start((), 0.0, ())
    one.take(object(), 0.0, ())  # type: ignore[arg-type]
    one.close()

    assert one.failure.startswith("KeyError")


def test_a_fault_of_the_side_channel_ends_nothing_else(tmp_path: Path) -> None:
    memory, told, begun = Memory(), course(100), header()
    side = SideChannel(ViewerMessages(mission(), None))
    side.follow(lambda now_s, wheels: 1 / 0)  # type: ignore[arg-type, return-value]
    one = Recorder(RecordingFile(memory, begun), begun, real_time=False, side=side)
    tell(one, told)
    one.close()

    assert side.failure.startswith("ZeroDivisionError")
    assert len(list(read(memory, tmp_path).steps())) == len(told) + 1


def test_a_file_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    DiskFile(path).close()

    with pytest.raises(FileExistsError):
        DiskFile(path)


def test_a_step_that_breaks_the_engine_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    prepared = prepare(Order("mitre_bend", backend="trace"))
    memory = Memory()
    one = recorder(memory)
    right, calls = Engine.step, 0

    def wrong(*arguments: object) -> object:
        nonlocal calls
        calls += 1
        return right(*arguments) if calls < 10 else 1 / 0  # type: ignore[arg-type]

    monkeypatch.setattr(Engine, "step", wrong)
    companions = [*prepared.companions, FirstChoice()]
    run = MissionRun(prepared.engine, prepared.backend, companions=companions, tap=one)
    result = run.execute()
    one.close()

    steps = list(read(memory, tmp_path).steps())

    assert result.exit_code == 4
    assert [step.by for step in steps] == ["start", *["engine"] * 10, "runtime"]
    assert steps[-2].effects == ()
    assert steps[-1].effects[-1] == result.ended


def test_bodies_at_rest_come_back() -> None:
    body = at_rest_in(mission().robot, 0)

    assert body_from_text(body_to_text(body)) == body
    assert body_from_text(body_to_text(None)) is None
    for wrong in ("[]", "{}", '{"configuration": "x"}', "nonsense"):
        with pytest.raises(ValueError):  # noqa: PT011 - of whatever kind
            body_from_text(wrong)
