from __future__ import annotations

import os

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pirate_sm.robot.rosserial.frames import LONGEST_PAYLOAD, Decoder, SerialFrame, encode

from . import captured

NIGHTLY = os.environ.get("NIGHTLY") == "1"

frames = st.builds(
    SerialFrame, st.integers(0, 0xFFFF), st.one_of(st.binary(max_size=40), st.binary(max_size=400))
)


@pytest.mark.parametrize("name", captured.ALL)
def test_captured_frames_are_read_and_written_to_the_byte(name: str) -> None:
    wire, topic, payload = captured.ALL[name]

    assert Decoder().feed(bytes.fromhex(wire)) == [SerialFrame(topic, bytes.fromhex(payload))]
    assert encode(topic, bytes.fromhex(payload)).hex() == wire


# Written out by hand: the check of the length is 255 - (low byte + high byte) modulo 256.
@pytest.mark.parametrize(
    ("length", "head"),
    [
        (255, "fffeff0000"),
        (256, "fffe0001fe"),
        (257, "fffe0101fd"),
        (511, "fffeff01ff"),
        (512, "fffe0002fd"),
    ],
)
def test_payloads_of_256_bytes_and_more_have_a_check_over_both_bytes_of_their_length(
    length: int, head: str
) -> None:
    wire = encode(7, bytes(length))

    assert wire[:5].hex() == head
    assert Decoder().feed(wire) == [SerialFrame(7, bytes(length))]


def test_a_payload_that_no_receiver_takes_is_not_written() -> None:
    with pytest.raises(ValueError, match="513 bytes"):
        encode(100, bytes(LONGEST_PAYLOAD + 1))


def test_a_frame_longer_than_any_is_no_frame_and_those_behind_it_come_at_once() -> None:
    head = bytes((0xFF, 0xFE, 0x00, 0x40, 255 - 0x40))

    assert Decoder().feed(head + encode(7, b"x")) == [SerialFrame(7, b"x")]


def test_what_belongs_to_no_frame_is_counted() -> None:
    decoder = Decoder()
    decoder.feed(b"noise" + encode(7, b"x") + b"\xff\xfe\x01\x01\x01" + encode(8))

    assert decoder.dropped == 10


def _decode(data: bytes, cuts: list[int]) -> list[SerialFrame]:
    decoder, found, at = Decoder(), [], 0
    for cut in sorted(cuts):
        end = min(cut, len(data))
        found += decoder.feed(data[at:end])
        at = max(at, end)
    return found + decoder.feed(data[at:])


def _valid_frames_within(data: bytes) -> set[tuple[int, int]]:
    """Begin and end of everything in there that is a frame, by the rule of the protocol."""
    found = set()
    for at in range(len(data) - 7):
        if data[at : at + 2] == b"\xff\xfe" and sum(data[at + 2 : at + 5]) % 256 == 255:
            length = data[at + 2] + 256 * data[at + 3]
            end = at + 8 + length
            if length <= LONGEST_PAYLOAD and end <= len(data):
                whole = sum(data[at + 5 : end]) % 256 == 255
                found |= {(at, end)} if whole else set()
    return found


@pytest.mark.timeout(0 if NIGHTLY else 120)
@settings(max_examples=1_000_000 if NIGHTLY else 300)
@given(
    data=st.lists(
        st.one_of(st.binary(max_size=60), st.just(b"\xff"), frames.map(lambda f: encode(*f)))
    ).map(b"".join),
    cuts=st.lists(st.integers(0, 3000), max_size=8),
)
def test_any_bytes_in_any_split_give_the_same_frames(data: bytes, cuts: list[int]) -> None:
    assert _decode(data, cuts) == Decoder().feed(data)


@pytest.mark.timeout(0 if NIGHTLY else 120)
@settings(max_examples=1_000_000 if NIGHTLY else 300)
@given(
    sent=st.lists(frames, min_size=1, max_size=6),
    damage=st.lists(
        st.tuples(
            st.integers(0, 5), st.integers(0, 407), st.integers(1, 255), st.sampled_from("xid")
        ),
        max_size=4,
    ),
)
def test_an_undamaged_frame_is_lost_only_to_a_valid_one_that_the_damage_made(
    sent: list[SerialFrame], damage: list[tuple[int, int, int, str]]
) -> None:
    wires = [encode(*frame) for frame in sent]
    hurt = set()
    for which, place, value, how in damage:
        if which < len(wires) and place < len(wires[which]):
            wire = bytearray(wires[which])
            if how == "x":
                wire[place] ^= value
            elif how == "i":
                wire.insert(place, value)
            else:
                del wire[place]
            wires[which] = bytes(wire)
            hurt.add(which)
    flush = bytes(LONGEST_PAYLOAD + 8)
    data = b"".join(wires) + flush

    found = Decoder().feed(data)

    places, at = [], 0
    for wire in wires:
        places.append((at, at + len(wire)))
        at += len(wire)
    false = {
        (begin, end)
        for begin, end in _valid_frames_within(data)
        if (begin, end) not in {places[k] for k in range(len(wires)) if k not in hurt}
    }
    for which, frame in enumerate(sent):
        begin, end = places[which]
        overlapped = any(b < end and begin < e for b, e in false)
        if which not in hurt and not overlapped:
            assert frame in found
