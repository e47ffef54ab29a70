"""A repaired recording holds what the torn one held, and other programs find its index."""

from __future__ import annotations

import errno
import struct
from collections.abc import Callable, Iterator
from math import isnan
from pathlib import Path
from random import Random

import pytest
from keeping import Memory, course, header, tell
from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC
from representative import thorough_but

from pirate_sm.core.effects import PhaseChange, Setpoints, StateChange
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.robot import confirmed_parts, state_change, states_of
from pirate_sm.running.recording.format.engine_topics import STATE
from pirate_sm.running.recording.read import repair as module
from pirate_sm.running.recording.read.mcap_content import FRAME
from pirate_sm.running.recording.read.pieces import Gap
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.read.repair import is_whole, repair
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import replay, rerun, same
from pirate_sm.running.recording.viewers.complete_recording import write_complete
from pirate_sm.running.recording.write import recorder
from pirate_sm.running.recording.write.recorder import PIECE_S, Recorder
from pirate_sm.running.recording.write.recording_file import DiskFile, RecordingFile
from pirate_sm.running.wiring import Order
from pirate_sm.running.wiring.resume_offer import end_of_run
from pirate_sm.views.console.recording_viewer import recorded_snapshots
from pirate_sm.views.showing.panels import idle, phases, states
from tests.unit.running.recording.recording_runs import read_end, record, spoilt_in


@pytest.fixture(scope="module")
def whole() -> bytes:
    """A recording in many pieces."""
    memory, begun = Memory(), header()
    one = Recorder(RecordingFile(memory, begun), begun, real_time=False, commit_s=3600.0)
    told = course(1_500)
    tell(one, [])
    for number, (event, at_s, effects) in enumerate(told):
        one.take(event, at_s, effects)
        if number % 100 == 0:
            one._commit()
    one.close()
    return memory.data


def cut(whole: bytes, folder: Path, length: int) -> Recording:
    path = folder / "cut.mcap"
    path.write_bytes(whole[:length])
    return read_recording(path)


@pytest.mark.thorough
def test_wherever_it_was_cut_off_everything_that_can_be_read_is_kept(
    whole: bytes, tmp_path: Path
) -> None:
    beginning = read_content_begins(whole, tmp_path)
    for number, length in enumerate(Random(5).sample(range(beginning, len(whole) - 1), 25)):
        torn = cut(whole, tmp_path, length)
        path = tmp_path / f"{number}.mcap"
        done = repair(torn, path)
        again = read_recording(path)

        assert list(again.steps()) == list(torn.steps())
        assert again.header == torn.header
        assert (done.steps, done.until_s) == (len(list(torn.steps())), torn.until_s)
        assert done.torn_bytes == torn.content.size - torn.content.whole
        assert (done.damage, done.gaps) == ("", ())
        assert again.content.complete
        assert again.complete == torn.complete
        assert again.notices == (() if torn.complete else torn.notices)
        assert is_whole(again)
        assert not is_whole(torn)


def test_a_repaired_file_is_written_piece_by_piece(
    whole: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise the whole of a long recording would be in memory."""
    written: list[int] = []
    right = DiskFile.write

    def write(self: DiskFile, data: bytes, /) -> None:
        written.append(len(data))
        right(self, data)

    monkeypatch.setattr(DiskFile, "write", write)
    monkeypatch.setattr(module, "_LEAST_BYTES", 1_000)
    path = tmp_path / "torn.mcap"
    path.write_bytes(whole[:-1])
    repair(read_recording(path), tmp_path / "again.mcap")

    assert len(written) > 5


def read_content_begins(whole: bytes, folder: Path) -> int:
    """Where the first piece begins, with its frame."""
    return cut(whole, folder, len(whole)).content.pieces[0].at - 9


def opens(path: Path) -> int:
    """How many messages the official reader finds by the index of a file."""
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        found = sum(1 for _ in reader.iter_messages())
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == found
        assert len(list(reader.iter_attachments())) == 1 + len(header().files)
    return found


def spoiled(whole: bytes) -> Iterator[bytes]:
    """The recording with an end that is none any more, in many ways."""
    yield whole[:-1]
    yield whole + b"\xff" * 400
    yield whole + whole
    begins = whole.rindex(MCAP0_MAGIC) - 20
    (index,) = struct.unpack_from("<Q", whole, begins)
    for at in Random(6).sample(range(index, len(whole)), 40):
        data = bytearray(whole)
        data[at] ^= 1 << at % 8
        yield bytes(data)


@pytest.mark.thorough
def test_whatever_became_of_the_end_the_official_reader_opens_what_there_is_then(
    whole: bytes, tmp_path: Path
) -> None:
    (tmp_path / "whole.mcap").write_bytes(whole)
    expected = opens(tmp_path / "whole.mcap")
    for number, data in enumerate(spoiled(whole)):
        spoilt, path = tmp_path / "spoilt.mcap", tmp_path / f"{number}.mcap"
        spoilt.write_bytes(data)
        recording = read_recording(spoilt)
        assert not is_whole(recording)
        assert "the index at the end of the file" in recording.notices[0]
        done = repair(recording, path)

        assert opens(path) == expected
        assert done.complete
        assert read_recording(path).notices == ()


def test_the_official_reader_finds_its_index(whole: bytes, tmp_path: Path) -> None:
    pieces = cut(whole, tmp_path, len(whole)).content.pieces
    torn = cut(whole, tmp_path, pieces[-1].at + 9)
    repair(torn, tmp_path / "good.mcap")
    with (tmp_path / "good.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        found = [(channel.topic, message.data) for _, channel, message in reader.iter_messages()]

    assert summary is not None
    assert summary.statistics is not None
    assert len(summary.chunk_indexes) == summary.statistics.chunk_count
    assert summary.statistics.message_count == len(found)
    assert summary.statistics.attachment_count == 1 + len(header().files)
    assert {schema.encoding for schema in summary.schemas.values()} == {"jsonschema"}


def test_small_pieces_become_large_ones(
    whole: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    torn = cut(whole, tmp_path, len(whole) - 1)
    repair(torn, tmp_path / "one.mcap")
    monkeypatch.setattr(module, "_LEAST_BYTES", 20_000)
    repair(torn, tmp_path / "many.mcap")

    assert len(torn.content.pieces) > 10
    assert len(read_recording(tmp_path / "one.mcap").content.pieces) == 1
    assert 1 < len(read_recording(tmp_path / "many.mcap").content.pieces) < 10


def test_where_the_disk_is_full_there_is_no_new_file(
    whole: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: DiskFile, data: bytes, /) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    torn = cut(whole, tmp_path, len(whole) - 1)
    monkeypatch.setattr(DiskFile, "write", full)

    with pytest.raises(OSError, match="No space left"):
        repair(torn, tmp_path / "new.mcap")
    assert not (tmp_path / "new.mcap").exists()


def test_where_records_cannot_be_told_apart_the_file_ends(whole: bytes, tmp_path: Path) -> None:
    pieces = cut(whole, tmp_path, len(whole)).content.pieces
    hit = pieces[len(pieces) // 7]
    data = bytearray(whole)
    data[hit.at - 1] ^= 0x40  # the length of the piece
    spoilt = tmp_path / "spoilt.mcap"
    spoilt.write_bytes(data)
    recording = read_recording(spoilt, damaged=True)
    assert not is_whole(recording)

    done = repair(recording, tmp_path / "good.mcap")

    again = read_recording(tmp_path / "good.mcap")
    every = list(read_recording(tmp_path / "cut.mcap").steps())
    kept = list(again.steps())
    assert 0 < len(kept) < len(every) / 4
    assert kept == every[: len(kept)]
    assert (done.steps, done.complete) == (len(kept), False)
    assert done.damage
    assert not again.complete
    assert again.lost == done.damage
    assert "the recording ends early" in again.notices[0]
    assert again.lost_end
    assert is_whole(again)


@pytest.mark.parametrize("places", [(3,), (3, 4, 9), (0,), (24,)], ids=str)
def test_a_wrong_bit_costs_its_own_piece_only(
    whole: bytes, tmp_path: Path, places: tuple[int, ...]
) -> None:
    before = cut(whole, tmp_path, len(whole))
    pieces = list(before.commits())
    assert len(pieces) == 25
    done = repair(spoilt_in(before, tmp_path / "spoilt.mcap", *places), tmp_path / "good.mcap")
    again = read_recording(tmp_path / "good.mcap")

    kept = [step for place, steps in enumerate(pieces) if place not in places for step in steps]
    assert [step.number for step in again.steps()] == [step.number for step in kept]
    assert done.steps == len(kept)
    assert (done.complete, again.complete) == (False, False)
    assert again.lost == done.damage
    assert done.damage.count("at byte") == len(places)
    assert again.gaps == done.gaps
    assert [gap.from_s for gap in done.gaps if 0 in places] == [0.0] * (0 in places)
    assert again.lost_end == (24 in places)
    assert is_whole(again)
    repair(again, tmp_path / "twice.mcap")
    assert read_recording(tmp_path / "twice.mcap").lost_end == again.lost_end


def without(recording: Recording, path: Path, place: int) -> Recording:
    """The recording without this piece, as if it had never been written."""
    data, hit = recording.path.read_bytes(), recording.content.pieces[place]
    path.write_bytes(data[: hit.at - FRAME.size] + data[hit.at + hit.size :])
    return read_recording(path, damaged=True)


@pytest.mark.parametrize("place", [3, 20])
def test_a_piece_that_is_missing_without_a_trace_is_a_gap_too(
    place: int, whole: bytes, tmp_path: Path
) -> None:
    before = cut(whole, tmp_path, len(whole))
    steps = list(before.commits())
    recording = without(before, tmp_path / "without.mcap", place)
    assert not is_whole(recording)

    done = repair(recording, tmp_path / "good.mcap")

    again = read_recording(tmp_path / "good.mcap")
    assert [gap.step for gap in done.gaps] == [steps[place + 1][0].number]
    assert not done.complete
    assert again.gaps == done.gaps
    assert again.notices
    assert len(list(again.steps())) == done.steps == sum(map(len, steps)) - len(steps[place])


@pytest.fixture(scope="module")
def marked(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A run with marks before its checkpoints, cut off before its index."""
    path = tmp_path_factory.mktemp("runs") / "run.mcap"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "CHECKPOINT_S", 2.0)
        record(path, Order("mitre_bend"))
    data = path.read_bytes()
    path.write_bytes(data[: read_end(data)])
    return read_recording(path)


def test_the_topics_of_a_damaged_piece_are_known_without_the_index(
    marked: Recording, tmp_path: Path
) -> None:
    pieces = list(marked.commits())
    done = repair(spoilt_in(marked, tmp_path / "spoilt.mcap", 0), tmp_path / "good.mcap")

    assert done.steps == sum(map(len, pieces[1:]))
    assert done.damage.count("at byte") == 1
    assert "unknown" not in done.damage
    with (tmp_path / "good.mcap").open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary is not None
    assert {it.topic for it in summary.channels.values()} >= {"/engine/out/Log", STATE.name}
    for channel in summary.channels.values():
        assert summary.schemas[channel.schema_id].name == "pirate_sm" + channel.topic.replace(
            "/", "."
        )


@pytest.mark.parametrize("made", [spoilt_in, without])
def test_without_its_first_piece_times_still_count_from_the_beginning_of_the_run(
    made: Callable[[Recording, Path, int], Recording], marked: Recording, tmp_path: Path
) -> None:
    repair(made(marked, tmp_path / "spoilt.mcap", 0), tmp_path / "good.mcap")
    again = read_recording(tmp_path / "good.mcap")
    first = next(again.steps())

    with recorded_mission(marked.header) as loaded:
        body = loaded.loaded_robot.profile.body
        places = list(recorded_places(again, body))
        wholly = list(recorded_places(marked, body))
        write_complete(again, loaded, tmp_path / "viewed.mcap")
    viewed = read_recording(tmp_path / "viewed.mcap")

    assert again.gaps == viewed.gaps == (Gap(first.number, 0.0, first.at_s - marked.origin_s),)
    assert first.at_s > marked.origin_s + 1.0
    assert again.until_s == viewed.until_s == marked.until_s
    assert again.origin_s == viewed.origin_s == marked.origin_s
    assert places == wholly[-len(places) :]
    assert again.starts_s[0] == pytest.approx(first.at_s - marked.origin_s)
    assert viewed.starts_s[0] == pytest.approx(first.at_s - marked.origin_s)


@pytest.mark.thorough
def test_without_its_first_piece_the_mission_is_executed_from_the_first_checkpoint_on(
    marked: Recording, tmp_path: Path
) -> None:
    repair(spoilt_in(marked, tmp_path / "spoilt.mcap", 0), tmp_path / "good.mcap")
    again = read_recording(tmp_path / "good.mcap")
    due = next(again.checkpoints())

    with recorded_mission(marked.header) as loaded:
        wholly = {it.step.number: it for it in rerun(marked, loaded)}
        for it in rerun(again, loaded):
            if it.step.number >= due.step:
                before = wholly[it.step.number]
                assert it.step.number == due.step or it.step.by == before.step.by
                assert same(it.state, before.state)
        done = replay(again, loaded, after=due)

    assert (done.difference, done.executed, done.until_s) == (None, True, marked.until_s)


def test_of_topics_that_nothing_names_is_said_once_that_they_are_unknown(
    whole: bytes, tmp_path: Path
) -> None:
    recording = cut(whole, tmp_path, read_end(whole))
    spoilt = spoilt_in(recording, tmp_path / "spoilt.mcap", 0)

    damages = repair(spoilt, tmp_path / "good.mcap").damage.split(" and ")

    assert len(damages) == len(set(damages)) > 1


def test_a_gap_is_between_the_last_step_before_and_the_first_after(tmp_path: Path) -> None:
    recording = record(tmp_path / "run.mcap", Order("mitre_bend"))
    pieces = [steps for steps in recording.commits() if steps]
    hit = len(pieces) // 2

    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", hit), tmp_path / "good.mcap")

    again, origin_s = read_recording(tmp_path / "good.mcap"), recording.origin_s
    (gap,) = again.gaps
    assert gap.step == pieces[hit + 1][0].number
    assert gap.from_s == pieces[hit - 1][-1].at_s - origin_s
    assert gap.until_s == pieces[hit + 1][0].at_s - origin_s
    assert gap.until_s - gap.from_s <= PIECE_S + 0.2
    assert again.until_s == recording.until_s
    assert f"nothing is known from {gap.from_s:.3f} s to {gap.until_s:.3f} s" in again.notices[0]


def test_after_a_gap_is_shown_what_frames_tell_and_nothing_that_was_counted(
    tmp_path: Path,
) -> None:
    recording = record(tmp_path / "run.mcap", Order("take_elbow"))
    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", 1), tmp_path / "good.mcap")
    again = read_recording(tmp_path / "good.mcap")
    (gap,) = again.gaps
    with recorded_mission(recording.header) as loaded:
        names = loaded.robot.vocabulary.numbers
        wholly = {it.step.number: it for it in rerun(recording, loaded, every_signal=True)}
        for after in rerun(again, loaded, every_signal=True):
            before, state = wholly[after.step.number], after.state
            if after.step.number < gap.step:
                assert same(state, before.state)
                continue
            assert isnan(state.sensing.shown[names.index("odometry")])
            gamma = names.index("gamma_1")
            if after.at_s > gap.until_s + 0.5:
                assert state.sensing.shown[gamma] == before.state.sensing.shown[gamma]
        done = replay(again, loaded)

    assert (done.difference, done.gap) == (None, gap)
    assert done.until_s == gap.from_s


@pytest.mark.parametrize("hit", thorough_but([3], [0, 3, 6]))
def test_after_a_gap_states_are_unproven_until_they_are_recorded(hit: int, tmp_path: Path) -> None:
    """They were those of before the gap, with clamps confirmed and a command under way."""
    recording = record(tmp_path / "run.mcap", Order("take_elbow"))
    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", hit), tmp_path / "good.mcap")
    again = read_recording(tmp_path / "good.mcap")
    change: StateChange | None = None
    phase, sent = "", False
    with recorded_mission(recording.header) as loaded:
        robot, program = loaded.robot, loaded.program
        for it in rerun(again, loaded):
            if it.step.number < again.gaps[0].step:
                continue
            for effect in it.step.effects:
                change = effect if isinstance(effect, StateChange) else change
                phase = effect.phase if isinstance(effect, PhaseChange) else phase
                sent = sent or isinstance(effect, Setpoints)
            assert it.state is not None
            body = it.state.robot
            unconfirmed = robot.regions if change is None else change.unconfirmed
            assert state_change(robot, body).unconfirmed == unconfirmed
            assert change is None or state_change(robot, body) == change
            assert it.state.words[: len(robot.regions)] == states_of(robot, body)
            assert change is not None or not confirmed_parts(robot, body)
            assert not phase or program.phase_of[it.state.mission.pc] == phase
            assert (body.motion, body.flight, body.loops) == (None, None, ())
            assert sent or all(map(isnan, body.values))
            assert not it.state.mission.begun
    assert change is not None
    assert phase


def test_the_console_draws_no_clamp_and_no_drive_of_before_a_gap(tmp_path: Path) -> None:
    recording = record(tmp_path / "run.mcap", Order("take_elbow"))
    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", 1), tmp_path / "good.mcap")
    again = read_recording(tmp_path / "good.mcap")
    snapshots = recorded_snapshots(again)
    before = snapshots.at(again.gaps[0].from_s)
    after = snapshots.at(again.gaps[0].until_s + 0.2)

    assert "driving forward" in idle(before)
    assert idle(after) == "what the wheels were last asked for is not known"
    assert not any(line.plain.startswith("●") for line in states(after, 60))


@pytest.mark.thorough
def test_the_console_counts_no_time_of_a_gap_for_the_phase_before_it(tmp_path: Path) -> None:
    recording = record(tmp_path / "run.mcap", Order("take_elbow"))
    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", 1), tmp_path / "good.mcap")
    again = read_recording(tmp_path / "good.mcap")
    (gap,) = again.gaps
    snapshots = recorded_snapshots(again)
    phase, since_s = snapshots.at(gap.from_s).story.phase
    spent_s = snapshots.at(gap.from_s).story.spent_s.get(phase, 0.0) + gap.from_s - since_s

    within = snapshots.at((gap.from_s + gap.until_s) / 2)
    assert not within.live
    assert not within.story.phase.phase
    assert "damaged" in within.story.recent[-1].line.text

    for after in (snapshots.at(gap.until_s + 0.2), snapshots.at(snapshots.length_s)):
        assert after.live or after.over
        assert after.story.spent_s[phase] == pytest.approx(spent_s)
        assert after.story.phase.phase != phase
    (shown,) = (each.plain for each in phases(after, 60, 20) if f" {phase} " in each.plain)
    assert float(shown.split()[-2]) == pytest.approx(spent_s, abs=0.1)


def test_a_run_with_a_gap_is_not_resumed_from_what_was_known_before_it(tmp_path: Path) -> None:
    recording = record(tmp_path / "run.mcap", Order("take_elbow"))
    repair(spoilt_in(recording, tmp_path / "spoilt.mcap", 1), tmp_path / "good.mcap")

    with pytest.raises(RecordingError, match=r"was damaged from .* is unknown"):
        end_of_run(tmp_path / "good.mcap")


def test_the_time_of_its_end_counts_from_the_beginning_of_the_run(tmp_path: Path) -> None:
    memory, begun, began_s = Memory(), header(), 5_000.0
    one = Recorder(RecordingFile(memory, begun), begun, real_time=False, commit_s=3600.0)
    one.start((), began_s, ())
    for number, (event, at_s, effects) in enumerate(course(100)):
        one.take(event, began_s + at_s, effects)
        if number % 20 == 0:
            one._commit()
    one.close()
    torn = cut(memory.data, tmp_path, len(memory.data) - 1)

    done = repair(torn, tmp_path / "good.mcap")

    assert done.until_s == pytest.approx(1.6)
    assert done.until_s == torn.until_s == read_recording(tmp_path / "good.mcap").until_s
    pieces = list(torn.commits())
    (gap,) = repair(spoilt_in(torn, tmp_path / "spoilt.mcap", 3), tmp_path / "gap.mcap").gaps
    assert gap.from_s == pytest.approx(pieces[2][-1].at_s - began_s)
    assert gap.until_s == pytest.approx(pieces[4][0].at_s - began_s)
