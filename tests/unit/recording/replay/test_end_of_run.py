"""What is known of a run when its recording was cut off."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.engine.state import EngineState
from pirate_sm.errors import RecordingError
from pirate_sm.recording.format.samples import Placed
from pirate_sm.recording.read.reader import Recording, read_end_of_recording, read_recording
from pirate_sm.recording.replay import end_of_run as module
from pirate_sm.recording.replay.end_of_run import end_of_run
from pirate_sm.recording.write import piece_maker, recorder
from pirate_sm.wiring import Order
from tests.unit.recording.recording_runs import record, record_cut_off

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


@pytest.mark.parametrize(("before_s", "known"), [(0.0, True), (0.95, True), (1.05, False)])
def test_belief_in_a_place_ends_a_second_after_it_was_noted(
    cut: Path, monkeypatch: pytest.MonkeyPatch, before_s: float, known: bool
) -> None:
    until_s = read_recording(cut).until_s
    noted = Placed(until_s - before_s, True, ((0.1, 0.0),) * 6)
    earlier = noted._replace(at_s=noted.at_s - 0.1)
    monkeypatch.setattr(module, "recorded_places", lambda *_: iter([earlier, noted]))

    assert end_of_run(cut).placed == (noted if known else None)
