from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.robot.rosserial.frames import SerialFrame, encode
from pirate_sm.simulation.bay.node_handle import Reception

BYTE_S = 1 / 5760
FRAMES = [
    (0, b"", "fffe0000ff0000ff"),
    (11, b"", "fffe0000ff0b00f4"),
    (10, bytes(8), "fffe0800f70a000000000000000000f5"),
    (10, bytes.fromhex("8cdd006b33718a22"), "fffe0800f70a008cdd006b33718a22d1"),
    (125, bytes.fromhex("04030080c943"), "fffe0600f97d0004030080c943ef"),
]


def arriving(data: bytes, start_s: float = 0.0) -> list[tuple[int, float]]:
    return [(byte, start_s + i * BYTE_S) for i, byte in enumerate(data)]


@pytest.mark.parametrize(("topic", "payload", "raw"), FRAMES)
def test_a_captured_frame_is_read(topic: int, payload: bytes, raw: str) -> None:
    assert Reception().feed(arriving(bytes.fromhex(raw))) == [SerialFrame(topic, payload)]


@pytest.mark.parametrize("at", range(8))
def test_a_damaged_frame_vanishes_and_the_next_one_comes(at: int) -> None:
    damaged = bytearray(encode(10, bytes(8)))
    damaged[at] ^= 0x10
    reception = Reception()

    assert reception.feed(arriving(bytes(damaged))) == []
    assert reception.feed(arriving(encode(11, b""), 0.1)) == [SerialFrame(11, b"")]


def test_a_frame_that_takes_longer_than_20_ms_is_dropped() -> None:
    raw = encode(10, bytes(8))
    quick, slow = Reception(), Reception()

    assert quick.feed(arriving(raw[:6]) + arriving(raw[6:], 0.015)) != []
    assert slow.feed(arriving(raw[:6]) + arriving(raw[6:], 0.021)) == []
    assert slow.dropped == 1


def test_what_comes_late_begins_anew() -> None:
    reception = Reception()
    reception.feed(arriving(encode(10, bytes(8))[:9]))

    assert len(reception.feed(arriving(encode(0, b""), 0.05))) == 1


@given(st.binary(max_size=300), st.lists(st.integers(0, 300), max_size=5))
def test_any_bytes_in_any_split_do_no_harm(data: bytes, cuts: list[int]) -> None:
    whole, split = Reception(), Reception()
    arrivals = arriving(data)
    expected = whole.feed(arrivals)
    edges = [0, *sorted(cuts), len(data)]
    found = [f for a, b in itertools.pairwise(edges) for f in split.feed(arrivals[a:b])]

    assert found == expected


@given(st.binary(max_size=200), st.integers(0, 0xFFFF), st.binary(max_size=40))
def test_after_a_pause_a_whole_frame_always_comes(
    garbage: bytes, topic: int, payload: bytes
) -> None:
    reception = Reception()
    reception.feed(arriving(garbage))

    frames = reception.feed(arriving(encode(topic, payload), 1.0))

    assert frames == [SerialFrame(topic, payload)]
