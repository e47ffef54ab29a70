"""The emulated bay is held to what is flashed: to equal bytes of a host both answer equal frames.

Two differences are meant. The emulated bay has the memory of rosserial's own client: it announces
it, and takes a short payload together with what came before. Its echoes come when those of the
robot at hand do; the binary's, when its boards have answered.
"""

from __future__ import annotations

from collections.abc import Sequence
from struct import unpack_from
from typing import NamedTuple

import numpy as np
import pytest

from pirate_sm.core.loading import load_pipe
from pirate_sm.robot.rosserial.frames import (
    LOG,
    PUBLISHER,
    SUBSCRIBER,
    TIME,
    Decoder,
    SerialFrame,
    TopicInfo,
    encode,
    read_topic,
    time_payload,
)
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import Device, VirtualBay

from .avr_bay import AvrBay, Built
from .test_binary import DRIVEN, HELD, array
from .test_tables import SIX_WHEELED, of

pytestmark = [pytest.mark.firmware, pytest.mark.timeout(900)]

PIPE = SIX_WHEELED.parents[1] / "sequences" / "pipes" / "straight_113.yaml"
STATE, ECHO = 125, 126


class Sent(NamedTuple):
    """What a host writes, in one call."""

    at_s: float
    data: bytes


def answers(device: Device, script: Sequence[Sent], until_s: float) -> list[SerialFrame]:
    """The frames with which the device answers, in order."""
    decoder, frames, now_s = Decoder(), list[SerialFrame](), 0.0
    device.open(0.0)
    for sent in [*script, Sent(until_s, b"")]:
        while now_s < sent.at_s:
            now_s = min(now_s + 0.002, sent.at_s)
            frames += decoder.feed(device.advance(now_s))
        if sent.data:
            device.receive(sent.data, now_s)
    assert not decoder.dropped
    return frames


@pytest.fixture
def bays(six_wheeled: Built) -> tuple[Device, Device]:
    """What is flashed, and what emulates it."""
    profile, _ = of(SIX_WHEELED)
    pipe, _ = load_pipe(PIPE)
    texts = message_texts(SIX_WHEELED, profile)
    emulated = VirtualBay(profile, pipe, texts, Switches(boot_s=0.0), seed=1)
    return AvrBay(six_wheeled, profile, SIX_WHEELED, pipe, seed=1), emulated


def introduced(frames: Sequence[SerialFrame]) -> list[TopicInfo]:
    """The topics that were introduced, without how much memory the device has for each."""
    found = (read_topic(*frame) for frame in on({PUBLISHER, SUBSCRIBER}, frames))
    return [topic._replace(buffer_bytes=0) for topic in found if topic is not None]


def on(topics: set[int], frames: Sequence[SerialFrame]) -> list[SerialFrame]:
    return [frame for frame in frames if frame.topic in topics]


def test_introductions_are_the_same(bays: tuple[Device, Device]) -> None:
    script = [Sent(0.1, encode(0)), Sent(1.0, encode(0)), Sent(1.01, encode(0))]

    real, emulated = (introduced(answers(bay, script, 2.0)) for bay in bays)

    assert len(real) == 9
    assert real == emulated


def test_the_time_is_asked_as_often_and_silence_follows_at_the_same_time(
    bays: tuple[Device, Device],
) -> None:
    told = [Sent(2.5 * n, encode(TIME, time_payload(n))) for n in range(1, 4)]
    script = [Sent(0.1, encode(0)), *told]

    real, emulated = (answers(bay, script, 22.0) for bay in bays)

    assert on({TIME}, real) == on({TIME}, emulated)
    assert abs(len(on({STATE}, real)) - len(on({STATE}, emulated))) <= 6


def test_boards_report_in_the_same_order(bays: tuple[Device, Device]) -> None:
    script = [Sent(0.1, encode(0)), Sent(2.0, encode(TIME, time_payload(0.0)))]

    real, emulated = (
        [frame.payload[0] for frame in on({STATE}, answers(bay, script, 4.0))] for bay in bays
    )

    at = emulated.index(real[0])
    count = min(len(real), len(emulated) - at)
    assert count > 200
    assert real[:count] == emulated[at : at + count]


def test_boards_report_the_same_of_a_robot_at_rest(bays: tuple[Device, Device]) -> None:
    """In messages of equal length; each reading has its own noise."""
    script = [Sent(0.1, encode(0)), Sent(2.0, encode(TIME, time_payload(0.0)))]

    real, emulated = (
        by_board([frame.payload for frame in on({STATE}, answers(bay, script, 4.0))])
        for bay in bays
    )

    assert real.keys() == emulated.keys()
    for board, counts in real.items():
        others = emulated[board]
        spread = np.sqrt(counts.var(axis=0) / len(counts) + others.var(axis=0) / len(others))
        differ = np.abs(counts.mean(axis=0) - others.mean(axis=0))
        assert np.all(differ <= 5.0 * spread + 0.5), board


def by_board(payloads: Sequence[bytes]) -> dict[int, np.ndarray]:
    """Counts of each board's channels, one row for each of its messages."""
    assert {len(payload) for payload in payloads} == {1 + 9 * 4}
    boards = {payload[0] for payload in payloads}
    return {
        board: np.array([unpack_from("<9f", each, 1) for each in payloads if each[0] == board])
        for board in boards
    }


@pytest.mark.parametrize("seed", range(3))
def test_to_a_conversation_of_any_frames_both_answer_the_same(
    bays: tuple[Device, Device], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    script, at_s, array_s = [Sent(0.1, encode(0))], 0.4, 0.0
    for number in range(100):
        counts = [int(count * rng.uniform(0, 1)) for count in DRIVEN]
        frames = {
            "array": encode(100, array(number, counts, HELD)),
            "time": encode(TIME, time_payload(at_s)),
            "topics": encode(0),
            "stop": encode(11),
            "log": encode(LOG, b"\0" * 5),
            "noise": bytes(rng.integers(0, 256, 20, dtype=np.uint8)),
        }
        what = rng.choice(list(frames), p=[0.55, 0.2, 0.1, 0.05, 0.05, 0.05])
        script.append(Sent(at_s, frames[what]))
        array_s = at_s if what == "array" else array_s
        at_s += rng.choice([0.14, 0.3, 0.7, 1.3])
        if abs((at_s - array_s + 0.25) % 0.5 - 0.25) < 0.1:  # the switch trips about then
            at_s += 0.2

    real, emulated = (answers(bay, script, at_s) for bay in bays)

    assert introduced(real) == introduced(emulated)
    assert abs(len(on({TIME}, real)) - len(on({TIME}, emulated))) <= 1
    assert on({ECHO}, real) == on({ECHO}, emulated)
    assert len(on({ECHO}, real)) > 30


def test_to_arrays_whole_damaged_and_missing_the_same_echoes_come(
    bays: tuple[Device, Device],
) -> None:
    """Frames are damaged in any byte; silences let the dead man's switch trip."""
    rng = np.random.default_rng(4)
    script, at_s = [Sent(0.1, encode(0))], 0.5
    for number in range(150):
        counts = [int(count * rng.uniform(0, 1)) for count in DRIVEN]
        frame = bytearray(encode(100, array(number, counts, HELD)))
        if number % 3 == 1:
            frame[int(rng.integers(len(frame)))] ^= int(rng.integers(1, 256))
        at_s += 0.12 if number % 10 else 1.3
        script.append(Sent(at_s, bytes(frame)))
        if number % 8 == 0:
            script.append(Sent(at_s + 0.05, encode(TIME, time_payload(at_s))))

    real, emulated = (on({ECHO}, answers(bay, script, at_s + 0.3)) for bay in bays)

    assert len(real) > 100
    assert real == emulated


def test_what_nobody_listens_to_is_answered_by_neither(bays: tuple[Device, Device]) -> None:
    script = [
        Sent(0.1, encode(0)),
        Sent(0.6, encode(LOG, b"")),
        Sent(0.7, encode(6, b"\0" * 8)),
        Sent(0.8, encode(11)),
        Sent(1.0, encode(100, array(1, DRIVEN, HELD))),
    ]

    real, emulated = (answers(bay, script, 2.0) for bay in bays)

    assert introduced(real) == introduced(emulated)
    assert on({ECHO}, real) == on({ECHO}, emulated) == []


def test_no_array_is_obeyed_before_the_topics_were_asked_for(bays: tuple[Device, Device]) -> None:
    """Had one of them obeyed, its dead man's switch would say so later."""
    script = [Sent(0.1, encode(100, array(1, DRIVEN, HELD))), Sent(0.2, encode(0))]

    real, emulated = (answers(bay, script, 2.0) for bay in bays)

    assert on({ECHO}, real) == on({ECHO}, emulated) == []
