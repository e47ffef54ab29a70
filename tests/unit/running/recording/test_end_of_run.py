"""What is known of a run when its recording was cut off."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from math import inf
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core._engine.robot.robot_state import Flight
from pirate_sm.core.effects import CommandStatus
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import RecordingError
from pirate_sm.running.recording.format.engine_topics import UNLOGGED, Placed
from pirate_sm.running.recording.read.pieces import Gap, Message
from pirate_sm.running.recording.read.reader import Recording, read_end_of_recording, read_recording
from pirate_sm.running.recording.replay import Rerun, rerun, same
from pirate_sm.running.recording.write import piece_maker, recorder
from pirate_sm.running.wiring import Order
from pirate_sm.running.wiring import resume_offer as module
from pirate_sm.running.wiring.resume_offer import end_of_run
from tests.unit.running.recording.recording_runs import ROOT, record, record_cut_off

CUT_S = 5.0


@pytest.fixture(scope="module")
def cut(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bend, cut off in its fifth second, in pieces with a checkpoint each second."""
    path = tmp_path_factory.mktemp("runs") / "cut.mcap"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "CHECKPOINT_S", 1.0)
        patch.setattr(recorder, "_HELP_AT", 30)
        patch.setattr(recorder, "_MOST_STEPS", 60)
        record_cut_off(path, Order("prepare_bend"), CUT_S)
    return path


def test_it_is_the_state_of_the_last_step(cut: Path) -> None:
    end = end_of_run(cut)

    last = list(read_recording(cut).steps())[-1]
    assert (end.last_step, end.last_s) == (last.number, last.at_s)
    assert end.last_s == pytest.approx(CUT_S, abs=0.1)
    assert end.placed is not None
    assert end.placed.known


def test_only_the_last_pieces_are_read(cut: Path) -> None:
    whole, end = read_recording(cut), read_end_of_recording(cut)

    pieces = whole.content.pieces
    left_out = len(pieces) - len(end.content.pieces)
    assert left_out > 1
    assert end.content.pieces == [pieces[0], *pieces[1 + left_out :]]
    assert end.until_s == whole.until_s
    at = end.checkpoint(end.until_s)
    found = whole.checkpoint(whole.until_s)
    assert at is not None
    assert found is not None
    assert at.step == found.step


@pytest.mark.parametrize("piece", [-1, -2, -3])
def test_a_torn_piece_leaves_the_steps_before_it(cut: Path, tmp_path: Path, piece: int) -> None:
    torn = tmp_path / "torn.mcap"
    place = read_recording(cut).content.pieces[piece]
    torn.write_bytes(cut.read_bytes()[: place.at + place.size // 2])

    end = end_of_run(torn)

    last = list(read_recording(torn).steps())[-1]
    assert end.last_step == last.number < end_of_run(cut).last_step


@pytest.mark.parametrize(("later", "refused"), [(-1, False), (0, False), (1, True), (None, True)])
def test_a_gap_matters_unless_a_checkpoint_has_followed_it(
    cut: Path, monkeypatch: pytest.MonkeyPatch, later: int | None, refused: bool
) -> None:
    checkpoint = read_end_of_recording(cut).checkpoint(inf)
    assert checkpoint is not None
    step = 1 if later is None else checkpoint.step + later
    monkeypatch.setattr(Recording, "gaps", (Gap(step, 1.0, 2.0),))
    if later is None:
        monkeypatch.setattr(Recording, "checkpoint", lambda recording, at_s: None)

    with pytest.raises(RecordingError, match="was damaged from") if refused else nullcontext():
        end_of_run(cut)


def test_without_marks_all_of_it_is_read(cut: Path, tmp_path: Path) -> None:
    bare = tmp_path / "bare.mcap"
    bare.write_bytes(cut.read_bytes().replace(b"pirate_sm.checkpoint", b"pirate_sm.something_"))

    assert end_of_run(bare).last_step == end_of_run(cut).last_step


def test_a_mission_at_its_end_does_not_go_on(tmp_path: Path) -> None:
    path = tmp_path / "whole.mcap"
    record(path, Order("prepare_bend"))

    with pytest.raises(RecordingError, match="has come to its end; run it again"):
        end_of_run(path)


def test_an_empty_recording_is_nothing_to_go_on_from(cut: Path, tmp_path: Path) -> None:
    path = tmp_path / "empty.mcap"
    data = cut.read_bytes()
    path.write_bytes(data[: read_recording(cut).content.pieces[0].at - 9])

    with pytest.raises(RecordingError, match="ends before its mission began"):
        end_of_run(path)


def test_a_replay_that_differs_is_refused(cut: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "same", lambda one, other: False)

    with pytest.raises(RecordingError, match=r"differs from it at .* cannot be relied on"):
        end_of_run(cut)


def test_a_recorded_state_that_differs_from_the_replay_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, right = tmp_path / "cut.mcap", piece_maker.state_to_text
    monkeypatch.setattr(recorder, "CHECKPOINT_S", 1.0)
    record_cut_off(path, Order("prepare_bend"), 2.5)
    # As where no checkpoint can be used, so that the replay passes those states.
    monkeypatch.setattr(Recording, "checkpoint", lambda recording, at_s: None)
    assert end_of_run(path).last_s == pytest.approx(2.5, abs=0.1)

    def wrong(state: EngineState) -> str:
        return right(state._replace(sensing=state.sensing._replace(loss=0.875)))

    monkeypatch.setattr(piece_maker, "state_to_text", wrong)
    record_cut_off(path, Order("prepare_bend"), 2.5)

    with pytest.raises(RecordingError, match="cannot be relied on"):
        end_of_run(path)


# --- a small mission ---------------------------------------------------------------------------

BRANCHING = f"""
format: 1
mission: branching
robot: {ROOT / "hardware_profiles" / "pirate_ii"}
start: a
phases:
  a: {{do: [{{log: now}}], wait: [{{after: 1 s, go: b}}, {{after: 4 s, go: again}}], within: {{time: 8 s, go: late}}}}
  again: {{do: [{{log: again}}], go: a}}
  b: {{do: [ClampFront, ClampRear], go: e}}
  late: {{do: [LATE, ClampRear], go: e}}
ends: {{e: {{succeed: Done}}}}
"""  # noqa: E501


def branching(
    folder: Path, until_s: float, late: str = "ToggleLighting", fails: bool = False
) -> Path:
    """A run that waits, after which one of several phases begins, recorded up to this time."""
    mission, path = folder / "branching.yaml", folder / "branching.mcap"
    mission.write_text(BRANCHING.replace("LATE", late), encoding="utf-8")
    record_cut_off(path, Order(str(mission), backend="trace"), until_s, fails=fails)
    return path


def slow_disk(patch: pytest.MonkeyPatch, before_s: float) -> None:
    """As if a step was not on the disk in time, so long before the end."""

    def messages(recording: Recording, *topics: str, since_s: float = -inf) -> Iterator[Message]:
        at_s = recording.until_s - before_s
        if topics == (UNLOGGED.name,) and at_s >= since_s:
            yield Message(UNLOGGED.name, 0, b"{}")

    patch.setattr(Recording, "messages", messages)


def test_the_next_command_may_have_been_sent_where_the_disk_was_slow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = branching(tmp_path, 0.5, late="ClampFront")
    index = end_of_run(path).loaded.robot.table.command_index["ClampFront"]
    assert end_of_run(path).maybe is None

    with monkeypatch.context() as patch:
        slow_disk(patch, 0.9)
        assert end_of_run(path).maybe == index
    slow_disk(monkeypatch, 1.1)
    assert end_of_run(path).maybe is None


def test_where_the_disk_was_slow_and_one_of_several_commands_is_next_nobody_knows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = branching(tmp_path, 0.5)
    slow_disk(monkeypatch, 0.0)

    with pytest.raises(RecordingError, match="one of ClampFront, ToggleLighting may have been"):
        end_of_run(path)


def test_the_next_command_is_not_the_last_of_the_mission_where_a_failure_ends_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission, path = tmp_path / "one.yaml", tmp_path / "one.mcap"
    mission.write_text(
        f"""
format: 1
mission: switching
robot: {ROOT / "hardware_profiles" / "pirate_ii"}
start: b
phases:
  b: {{wait: [{{after: 4 s, go: c}}], within: {{time: 8 s, go: e}}}}
  c: {{wait: [{{after: 1 s, go: d}}], within: {{time: 2 s, go: a}}}}
  d: {{go: c}}
  a: {{do: [{{control: exp_3a}}, ToggleLighting], go: z}}
  z: {{do: [ClampFront], go: e}}
ends: {{e: {{succeed: Done}}}}
""",
        "utf-8",
    )
    record_cut_off(path, Order(str(mission), backend="trace"), 0.5)
    slow_disk(monkeypatch, 0.0)

    end = end_of_run(path)

    assert end.maybe == end.loaded.robot.table.command_index["ToggleLighting"]


def test_an_array_of_a_loop_in_flight_says_nothing_about_the_next_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = branching(tmp_path, 0.5, late="ClampFront")

    def streaming(*given: Any) -> Iterator[Rerun]:
        for again in rerun(*given):
            assert again.state is not None
            robot = again.state.robot
            flight = Flight(robot.next_id, robot.latest, "stream")
            state = again.state._replace(robot=robot._replace(flight=flight))
            yield again._replace(step=again.step._replace(state=None), state=state)

    slow_disk(monkeypatch, 0.0)
    monkeypatch.setattr(module, "rerun", streaming)

    assert end_of_run(path).maybe is not None


def test_a_command_in_flight_is_the_last_that_can_have_been_sent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "_MOST_STEPS", 1)
    monkeypatch.setattr(recorder, "_HELP_AT", 1)
    path = branching(tmp_path, 60.0)
    whole, cuts = path.read_bytes(), read_recording(path).content.pieces
    slow_disk(monkeypatch, 0.0)

    sent = 0
    for cut in cuts[1:]:
        path.write_bytes(whole[: cut.at])
        steps = [*read_recording(path).steps()]
        if any(isinstance(it, CommandStatus) and it.status == "sent" for it in steps[-1].effects):
            sent += 1
            assert end_of_run(path).maybe is None
    assert sent == 2


def test_the_run_ends_with_its_checkpoint_where_nothing_follows_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "CHECKPOINT_S", 0.0)
    path = branching(tmp_path, 2.0)
    checkpoint = read_recording(path).checkpoint(inf)
    assert checkpoint is not None

    end = end_of_run(path)

    assert end.last_step == checkpoint.step == read_recording(path).last_step.number
    assert same(end.last, checkpoint.state)
    with pytest.raises(RecordingError, match="has come to its end"):
        end_of_run(branching(tmp_path, 60.0))


def test_a_run_that_its_program_has_abandoned_does_not_go_on(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="has come to its end"):
        end_of_run(branching(tmp_path, 2.0, fails=True))


@pytest.mark.parametrize(("before_s", "known"), [(0.0, True), (1.0, True), (1.05, False)])
def test_belief_in_a_place_ends_a_second_after_it_was_noted(
    cut: Path, monkeypatch: pytest.MonkeyPatch, before_s: float, known: bool
) -> None:
    until_s = read_recording(cut).until_s
    noted = Placed(until_s - before_s, True, ((0.1, 0.0),) * 6)
    earlier = noted._replace(at_s=noted.at_s - 0.1)
    monkeypatch.setattr(module, "recorded_places", lambda *_: iter([earlier, noted]))

    assert end_of_run(cut).placed == (noted if known else None)
