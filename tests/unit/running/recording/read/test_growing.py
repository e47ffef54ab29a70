"""A recording is followed while another process writes it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from keeping import Memory, course, header, tell

from pirate_sm.running.recording.read.growing import QUIET_S, GrowingRecording
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.write.recorder import Recorder
from pirate_sm.running.recording.write.recording_file import RecordingFile


@pytest.fixture(scope="module")
def whole() -> bytes:
    """A recording in several pieces."""
    memory, begun = Memory(), header()
    one = Recorder(RecordingFile(memory, begun), begun, real_time=False, commit_s=3600.0)
    tell(one, [])
    for number, (event, at_s, effects) in enumerate(course(300)):
        one.take(event, at_s, effects)
        if number % 60 == 0:
            one._commit()
    one.close()
    return memory.data


class Wall:
    """A clock that a test moves."""

    def __init__(self) -> None:
        self.now_s = 1_000.0

    def __call__(self) -> float:
        return self.now_s


def first_piece(whole: bytes, folder: Path) -> int:
    """Where the first piece of the run begins."""
    file = folder / "whole.mcap"
    file.write_bytes(whole)
    return read_recording(file).content.pieces[0].at - 9


@pytest.mark.parametrize("stride", [400, 1_777, 10_000])
def test_what_is_read_while_it_grows_is_what_is_read_at_the_end(
    whole: bytes, tmp_path: Path, stride: int
) -> None:
    file, length = tmp_path / "run.mcap", first_piece(whole, tmp_path)
    file.write_bytes(whole[:length])
    growing = GrowingRecording(file)

    def more() -> bool:
        nonlocal length
        while length < len(whole):
            file.write_bytes(whole[: (length := length + stride)])  # cut anywhere
            if growing.grow():
                return True
        return False

    assert more()
    steps = [*growing.so_far(more).steps()]

    expected = read_recording(tmp_path / "whole.mcap")
    assert [each.number for each in steps] == [each.number for each in expected.steps()]
    assert steps[-1].effects == expected.last_step.effects
    assert growing.complete
    assert growing.so_far().complete
    assert growing.so_far().until_s == expected.until_s


def test_a_run_whose_recording_stands_still_may_have_ended(whole: bytes, tmp_path: Path) -> None:
    file, length, wall = tmp_path / "run.mcap", first_piece(whole, tmp_path), Wall()
    file.write_bytes(whole[: length + 5_000])
    growing = GrowingRecording(file, wall)
    assert growing.under_way

    wall.now_s += QUIET_S + 1.0
    assert not growing.under_way
    assert not growing.complete

    file.write_bytes(whole)
    assert growing.grow()
    assert growing.complete
    assert not growing.under_way


def test_an_old_file_without_an_end_is_not_under_way(whole: bytes, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    file.write_bytes(whole[: first_piece(whole, tmp_path) + 5_000])
    os.utime(file, (0, 0))

    assert not GrowingRecording(file).under_way


def test_damage_in_the_middle_is_the_end(whole: bytes, tmp_path: Path) -> None:
    file, length = tmp_path / "run.mcap", first_piece(whole, tmp_path)
    spoilt = bytearray(whole)
    piece = read_recording(tmp_path / "whole.mcap").content.pieces[1]
    file.write_bytes(whole[: length + 9])
    growing = GrowingRecording(file)
    spoilt[piece.at - 9] = 0
    file.write_bytes(spoilt)

    growing.grow()

    assert len(growing.so_far().content.pieces) == 1
