"""Recordings that were cut off, are something else, or were changed later."""

from __future__ import annotations

import json
import tracemalloc
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from random import Random
from typing import Any

import pytest
from keeping import Memory, course, header, recorder, tell
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC, Writer

from pirate_sm.core.errors import RecordingError
from pirate_sm.running.recording.format.engine_topics import Topic
from pirate_sm.running.recording.read.mcap_content import read_content
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.write.recorder import Recorder
from pirate_sm.running.recording.write.recording_file import RecordingFile

STEPS, PIECES = 6_000, 12


@pytest.fixture(scope="module")
def whole() -> bytes:
    """A recording of several commits."""
    memory, begun = Memory(), header()
    file = RecordingFile(memory, begun)
    one = Recorder(file, begun, real_time=False, commit_s=3600.0)
    told = course(STEPS)
    one.start((), 0.0, ())
    for number, (event, at_s, effects) in enumerate(told):
        one.take(event, at_s, effects)
        if number % (STEPS // PIECES) == 0:
            one._commit()
    one.close()
    assert not one.failure
    return memory.data


def steps_in(data: bytes, folder: Path) -> tuple[int, tuple[str, ...]]:
    """How many steps a file with these bytes gives, and what is said of it."""
    path = folder / "run.mcap"
    path.write_bytes(data)
    recording = read_recording(path)
    return len(list(recording.steps())), recording.notices


def test_the_official_reader_opens_it(whole: bytes) -> None:
    reader = make_reader(BytesIO(whole), validate_crcs=True)
    summary = reader.get_summary()
    found = {channel.topic for _, channel, _ in reader.iter_messages()}

    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.chunk_count >= PIECES
    assert summary.statistics.attachment_count == 1 + len(header().files)
    assert "/engine/in/SensorFrame/22" in found
    assert {schema.encoding for schema in summary.schemas.values()} == {"jsonschema"}


def chunks_of(whole: bytes) -> list[tuple[int, int]]:
    """Where each chunk begins and ends."""
    at, found = len(MCAP0_MAGIC), []
    while at < len(whole) - len(MCAP0_MAGIC):
        end = at + 9 + int.from_bytes(whole[at + 1 : at + 9], "little")
        if whole[at] == Opcode.CHUNK:
            found.append((at, end))
        at = end
    return found


@pytest.mark.thorough
def test_a_recording_cut_off_anywhere_is_read_up_to_there(whole: bytes, tmp_path: Path) -> None:
    chunks = chunks_of(whole)
    before = 0
    for length in sorted(Random(3).sample(range(chunks[0][0], len(whole)), 60)):
        steps, notices = steps_in(whole[:length], tmp_path)

        assert steps >= before
        assert (steps > 0) == (length >= chunks[0][1])
        over = any(
            text in notices[0] for text in ("all that was recorded is there", "the run had ended")
        )
        assert over == (steps == STEPS + 2)
        assert ("ends early" in notices[0]) == (steps < STEPS + 2)
        before = steps
    assert before == STEPS + 2


def test_at_whatever_byte_it_is_cut_off_whole_pieces_stay_and_nothing_else(
    whole: bytes,
) -> None:
    chunks = chunks_of(whole)[:2]
    ends = [end for _, end in chunks]
    for length in range(chunks[0][0], chunks[-1][1] + 40):
        content = read_content(BytesIO(whole[:length]))

        assert len(content.pieces) == sum(end <= length for end in ends)
        assert not content.complete
        assert content.size == length
        assert chunks[0][0] <= content.whole <= length
        assert content.whole >= max((end for end in ends if end <= length), default=0)


def test_until_when_a_recording_holds_is_said(whole: bytes, tmp_path: Path) -> None:
    begins, _ = chunks_of(whole)[7]
    path = tmp_path / "run.mcap"
    path.write_bytes(whole[: begins + 300])
    recording = read_recording(path)
    *_, last = recording.steps()

    assert recording.until_s == last.at_s
    assert f"at {last.at_s:.3f} s" in recording.notices[0]


def test_no_recording_is_too_large(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    chunks = chunks_of(whole)
    begins, _ = chunks[len(chunks) * 2 // 3]
    path.write_bytes(whole[:begins])
    with path.open("r+b") as file:
        file.truncate(3 << 30)  # a hole, as some file systems leave one after a power cut

    recording = read_recording(path)

    assert len(list(recording.steps())) > STEPS // 2
    assert not recording.complete


def test_only_the_piece_that_is_read_is_in_memory(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    recording = read_recording(path)
    tracemalloc.start()
    try:
        most = [0.0, 0.0]
        for step in recording.steps():
            half = step.number >= STEPS // 2
            most[half] = max(most[half], tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()

    assert most[1] < most[0] * 1.2


def test_whoever_watches_is_told_how_much_has_been_read(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    told: list[float] = []
    for _ in read_recording(path, told.append).steps():
        pass

    assert told == sorted(told)
    assert told[-1] == 1.0
    assert len(told) > PIECES


def test_a_recording_cut_off_in_its_beginning_holds_nothing(whole: bytes, tmp_path: Path) -> None:
    beginning = chunks_of(whole)[0][0]
    for length in Random(3).sample(range(beginning), 30):
        with pytest.raises(RecordingError, match="interrupted before anything was recorded"):
            steps_in(whole[:length], tmp_path)


@pytest.mark.thorough
def test_a_recording_damaged_in_its_beginning_is_not_called_cut_off(
    whole: bytes, tmp_path: Path
) -> None:
    begins, _ = chunks_of(whole)[0]
    for at in (8, 60, *range(70, begins - 9, 61)):
        data = bytearray(whole)
        data[at : at + 8] = bytes(each ^ 0xFF for each in data[at : at + 8])
        with pytest.raises(RecordingError, match=r"is damaged: at byte \d+$"):
            steps_in(bytes(data), tmp_path)


@pytest.mark.parametrize("junk", [b"\0" * 5_000, b"\7" * 5_000, bytes(range(1, 256)) * 20])
@pytest.mark.parametrize("left", [0, 5, 300])
def test_what_a_power_cut_leaves_behind_the_last_chunk_does_not_count(
    whole: bytes, tmp_path: Path, junk: bytes, left: int
) -> None:
    begins, _ = chunks_of(whole)[7]
    expected, _ = steps_in(whole[:begins], tmp_path)

    steps, notices = steps_in(whole[: begins + left] + junk, tmp_path)

    assert steps == expected
    assert len(notices) == 1


@pytest.mark.thorough
def test_a_changed_byte_is_noticed_or_without_consequence(whole: bytes, tmp_path: Path) -> None:
    expected, _ = steps_in(whole, tmp_path)
    random = Random(4)
    refused = 0
    for _ in range(80):
        data = bytearray(whole)
        data[random.randrange(len(data))] ^= 1 << random.randrange(8)
        try:
            assert steps_in(bytes(data), tmp_path)[0] == expected
        except RecordingError:
            refused += 1
    assert refused > 50


def test_damage_in_the_middle_is_not_taken_for_the_end(whole: bytes, tmp_path: Path) -> None:
    chunks = chunks_of(whole)
    cut = bytearray(whole[: chunks[8][0] + 100])
    cut[chunks[5][0] + 200] ^= 0xFF

    with pytest.raises(RecordingError, match=r"is damaged: at byte \d+"):
        steps_in(bytes(cut), tmp_path)


def test_a_missing_piece_is_noticed(whole: bytes, tmp_path: Path) -> None:
    chunks = chunks_of(whole)
    begins, ends = chunks[5]

    with pytest.raises(RecordingError, match="steps are missing"):
        steps_in(whole[:begins] + whole[ends : chunks[8][0]], tmp_path)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "interrupted before anything"),
        (MCAP0_MAGIC[:5], "interrupted before anything"),
        (MCAP0_MAGIC, "interrupted before anything"),
        (b"%PDF-1.7 something else", "it is not an MCAP file"),
        (b"\0" * 100, "it is not an MCAP file"),
    ],
)
def test_something_else_is_called_that(data: bytes, said: str, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=said):
        steps_in(data, tmp_path)


def test_an_mcap_file_of_somebody_else_is_called_that(tmp_path: Path) -> None:
    stream = BytesIO()
    writer = Writer(stream)
    writer.start("ros2")
    writer.finish()  # type: ignore[no-untyped-call]

    with pytest.raises(RecordingError, match="not a recording of a mission"):
        steps_in(stream.getvalue(), tmp_path)


@pytest.mark.parametrize("name", ["nowhere.mcap", ".", "a\0b"])
def test_a_file_that_cannot_be_read_is_reported(name: str, tmp_path: Path) -> None:
    with pytest.raises(RecordingError) as caught:
        read_recording(tmp_path / name)

    assert caught.value.exit_code == 2


@pytest.mark.parametrize("key", ["format", "alphabet"])
def test_a_recording_of_another_version_is_refused(
    key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = header().to_json()
    monkeypatch.setattr(type(header()), "to_json", lambda self: {**plain, key: 99})
    memory = Memory()
    recorder(memory).close()

    with pytest.raises(RecordingError, match=rf"which this version cannot read.*{key} \d"):
        steps_in(memory.data, tmp_path)


@pytest.mark.parametrize(
    "change",
    [
        {"files": [{"role": "mission"}]},
        {"mission": 3},
        {"boards": {"x": ["a"]}},
    ],
)
def test_a_header_that_says_something_else_is_refused(
    change: dict[str, object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = header().to_json()
    monkeypatch.setattr(type(header()), "to_json", lambda self: {**plain, **change})
    memory = Memory()
    recorder(memory).close()

    with pytest.raises(RecordingError, match="has unexpected content"):
        steps_in(memory.data, tmp_path)


def test_a_text_that_was_changed_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = json.loads(json.dumps(header().to_json()))
    plain["files"][0]["sha256"] = "0" * 64
    monkeypatch.setattr(type(header()), "to_json", lambda self: plain)
    memory = Memory()
    recorder(memory).close()

    with pytest.raises(RecordingError, match="is not the text that was run"):
        steps_in(memory.data, tmp_path)


def test_a_run_without_a_step_is_a_recording(tmp_path: Path) -> None:
    memory = Memory()
    one = recorder(memory)
    tell(one, [])
    one.close()

    assert steps_in(memory.data, tmp_path) == (1, ())


def test_each_input_is_decoded_once(
    whole: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    right, decoded = Topic.decode, list[bytes]()

    def counted(topic: Topic, data: bytes) -> Iterator[tuple[int, float, int, Any]]:
        decoded.append(data)
        return right(topic, data)

    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    recording = read_recording(path)
    monkeypatch.setattr(Topic, "decode", counted)

    assert len(list(recording.steps())) > STEPS
    assert len(decoded) == len(set(decoded))
