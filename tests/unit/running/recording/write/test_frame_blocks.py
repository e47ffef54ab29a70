"""Frames handed over as a block are recorded as if they had come one by one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from math import inf, nan
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from keeping import Memory, header, mission

from pirate_sm.core.effects import Effect, WakeAt
from pirate_sm.core.events import Event, FrameBlock, SensorFrame, Tick, Trail, Whereabouts
from pirate_sm.core.sensing import Glide, Step
from pirate_sm.running.recording.format.engine_topics import PlacesSample, places_sample
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.write import recorder as module
from pirate_sm.running.recording.write.piece_maker import PlacesOfTrail
from pirate_sm.running.recording.write.recorder import Recorder
from pirate_sm.running.recording.write.recording_file import RecordingFile
from pirate_sm.running.recording.write.sampler import KeptSamples

WIDTHS = {board: len(channels) for board, channels in header().boards.items() if channels}
CYCLE_S = 0.016
Told = tuple[Event, float, tuple[Effect, ...]]

NUMBERS = st.one_of(st.integers(-4096, 4096).map(float), st.floats())
FRAMES = st.lists(
    st.tuples(st.sampled_from(sorted(WIDTHS)), st.lists(NUMBERS, min_size=9, max_size=9)),
    min_size=1,
    max_size=8,
)


def block_of(frames: list[tuple[int, list[float]]], first_s: float) -> FrameBlock:
    """The frames as a compiled simulator hands them over; rows are as long as the longest."""
    times_s = [first_s + number * CYCLE_S for number in range(len(frames))]
    boards, rows = zip(*frames, strict=True)
    return FrameBlock(times_s, list(boards), np.array(rows, dtype=np.float64), WIDTHS)


def glide_of(block: FrameBlock, steps: Sequence[Step] = (), trail: Trail | None = None) -> Glide:
    """A glide of these frames, with other steps among them."""
    return Glide(block.times_s[-1], None, block, steps, trail=trail)


def rows(times_s: Sequence[float]) -> bytes:
    """A trail on which each wheel is at x = time."""
    return np.array(times_s).tobytes()


def whereabouts(noted: Sequence[bytes]) -> Whereabouts:
    """What is read of such a trail."""
    places_m = [(at_s, 0.5) * 6 for at_s in np.frombuffer(b"".join(noted)).tolist()]
    return Whereabouts(places_m, [()] * len(places_m), [()] * len(places_m))


def look_back(times_s: Sequence[float], trail: Trail) -> PlacesOfTrail:
    """Samples of a trail."""

    def samples(kept: Sequence[PlacesOfTrail]) -> Iterator[PlacesSample]:
        places_m = trail.read([each.noted for each in kept]).places_m
        all_s = chain.from_iterable(each.times_s for each in kept)
        for at_s, places in zip(all_s, places_m, strict=True):
            yield PlacesSample(at_s, True, places)

    return PlacesOfTrail(times_s, trail.noted(times_s), samples)


def read(memory: Memory, folder: Path) -> Recording:
    path = folder / "run.mcap"
    path.write_bytes(memory.data)
    return read_recording(path)


def recorder_of(memory: Memory, side: KeptSamples | None = None) -> Recorder:
    begun = header(viewers=False)
    file = RecordingFile(memory, begun)
    return Recorder(file, begun, real_time=False, side=side, commit_s=3600.0)


@settings(deadline=None, max_examples=20)
@given(st.lists(st.tuples(FRAMES, st.booleans()), min_size=1, max_size=8), st.integers(1, 40))
def test_a_block_is_read_as_its_frames(
    tmp_path_factory: pytest.TempPathFactory,
    stretches: list[tuple[list[tuple[int, list[float]]], bool]],
    help_at: int,
) -> None:
    memory, told = Memory(), list[Told]()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_HELP_AT", help_at)
        patch.setattr(module, "_MOST_STEPS", 2 * help_at)
        one = recorder_of(memory)
        one.start((), 0.0, ())
        now_s = 0.0
        for frames, as_block in stretches:
            block = block_of(frames, now_s)
            middle = len(block) // 2
            at_s, effects = block.times_s[middle], (WakeAt(now_s + 2.0),)
            steps = [(at_s, block.frame(middle), effects), (at_s, Tick(), effects)]
            glide = glide_of(block, steps)
            if as_block:
                one.take_glide(glide)
            else:
                for step_s, event, caused in glide.in_order():
                    one.take(event, step_s, caused)
            told += [(event, step_s, caused) for step_s, event, caused in glide.in_order()]
            now_s = block.times_s[-1] + CYCLE_S
            one.take(Tick(), now_s, (WakeAt(now_s + 1.0),))
            told.append((Tick(), now_s, (WakeAt(now_s + 1.0),)))
        one.close()
    assert one.failure == ""

    steps = list(read(memory, tmp_path_factory.mktemp("read")).steps())

    assert [step.number for step in steps] == list(range(len(told) + 1))
    found = [(step.event, step.at_s, step.effects) for step in steps[1:]]
    assert repr(found) == repr(told)  # NaN does not equal itself


def test_samples_within_a_block_are_taken_when_they_are_due(tmp_path: Path) -> None:
    loaded, memory = mission(), Memory()
    side = KeptSamples()
    here = ((9.0, 9.0),) * 6
    side.follow(lambda now_s, stood: places_sample(now_s, True, here), look_back)
    one = recorder_of(memory, side)
    one.start((), 0.0, ())

    tick = 0.215, Tick(), (WakeAt(0.465),)
    frames = [(22, [float(number)] * 9) for number in range(20)]
    trail = Trail(0.35, rows, whereabouts)
    one.take_glide(glide_of(block_of(frames, CYCLE_S), [tick], trail))
    one.take(Tick(), 0.45, ())
    one.take_glide(glide_of(block_of(frames[:3], 0.46), trail=trail))
    one.take_glide(glide_of(block_of(frames, 0.6), trail=trail))
    one.close()

    recording = read(memory, tmp_path)
    body = loaded.loaded_robot.profile.body
    found = [(placed.at_s, placed.wheels[0][0]) for placed in recorded_places(recording, body)]
    on_the_trail = [0.112, 0.215, 0.32]
    later = [0.6, 0.712, 0.824]
    expected = [(0.0, 9.0), *((at_s, at_s) for at_s in on_the_trail), (0.45, 9.0)]
    expected += [(at_s, at_s) for at_s in later]
    assert found == [(pytest.approx(at_s), pytest.approx(x)) for at_s, x in expected]


@pytest.mark.thorough
def test_a_recording_of_blocks_cut_off_anywhere_is_read_up_to_there(tmp_path: Path) -> None:
    loaded, memory = mission(), Memory()
    body = loaded.loaded_robot.profile.body
    side = KeptSamples()
    side.follow(lambda now_s, stood: places_sample(now_s, True, ((1.0, 2.0),) * 6))
    one = recorder_of(memory, side)
    one.start((), 0.0, ())
    begins = len(memory.data)
    now_s = 0.0
    for _ in range(12):
        block = block_of([(22, [now_s] * 9), (23, [nan] * 9)] * 5, now_s)
        one.take_glide(glide_of(block))
        now_s = block.times_s[-1] + CYCLE_S
        one.take(Tick(), now_s, (WakeAt(now_s),))
        one._commit()
    one.close()
    whole = read(memory, tmp_path)
    steps, places = list(whole.steps()), list(recorded_places(whole, body))
    assert (len(steps), len(places)) == (1 + 12 * 11, 13)

    most = 0
    for length in sorted(Random(8).sample(range(begins, len(memory.data)), 80)):
        torn = Memory()
        torn.data = memory.data[:length]
        recording = read(torn, tmp_path)
        found = list(recording.steps())

        assert repr(found) == repr(steps[: len(found)])
        assert len(found) in range(most, len(steps) + 1)
        assert not found or len(found) % 11 == 1  # whole pieces
        until_s = recording.until_s + 1e-9 if found else -1.0
        seen = list(recorded_places(recording, body))
        assert seen == [placed for placed in places if placed.at_s <= until_s]
        most = len(found)
    assert most == len(steps)


def test_a_checkpoint_follows_a_block(tmp_path: Path) -> None:
    memory, asked = Memory(), 0

    def look() -> None:
        nonlocal asked
        asked += 1

    one = recorder_of(memory)
    one.follow(look)
    one.start((), 0.0, ())
    one.take_glide(glide_of(block_of([(22, [0.0] * 9)], 0.016)))
    one.take_glide(glide_of(block_of([(22, [0.0] * 9)], 100.0)))
    one.close()

    assert asked == 1
    assert read(memory, tmp_path).until_s == 100.0


def test_frames_of_a_block_that_fit_no_board_end_the_recording_only() -> None:
    one = recorder_of(Memory())
    one.start((), 0.0, ())
    one.take_glide(glide_of(FrameBlock([0.1], [99], np.zeros((1, 9)), {99: 9})))
    one.close()

    assert one.failure


def test_one_by_one_and_as_a_block_give_the_same_file() -> None:
    frames = [(22, [float(number)] * 9) for number in range(50)]
    block, files = block_of(frames, 0.016), []
    for as_block in (True, False):
        memory = Memory()
        one = recorder_of(memory)
        one.start((), 0.0, ())
        if as_block:
            one.take_glide(glide_of(block))
        else:
            for at_s, frame in block.frames():
                one.take(SensorFrame(frame.board, frame.values), at_s, ())
        one.close()
        files.append(memory.data)

    assert files[0] == files[1]
    assert inf not in block.times_s
