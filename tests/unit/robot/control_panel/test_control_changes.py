"""Control changes are found in any stream of bytes, whatever else is in it."""

from __future__ import annotations

import random

from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.robot.control_panel.presses import ControlChange, ControlChangeParser


def found(data: bytes) -> list[ControlChange]:
    return ControlChangeParser().take(data)


def test_three_bytes_are_a_control_change() -> None:
    assert found(bytes([0xB2, 42, 127])) == [(3, 42, 127)]


def test_further_pairs_need_no_status() -> None:
    assert found(bytes([0xB0, 1, 2, 3, 4])) == [(1, 1, 2), (1, 3, 4)]


def test_a_clock_between_any_two_bytes_changes_nothing() -> None:
    assert found(bytes([0xF8, 0xB0, 0xFE, 42, 0xF8, 127, 0xFF, 43, 0xFA, 0])) == [
        (1, 42, 127),
        (1, 43, 0),
    ]


def test_the_data_of_other_messages_are_no_control_changes() -> None:
    note, program, exclusive = b"\x90\x3c\x7f", b"\xc0\x05", b"\xf0\x42\x00\x01\xf7"
    parser = ControlChangeParser()

    assert parser.take(note + program + exclusive + b"\x2a\x7f") == []
    assert parser.others == 2
    assert parser.take(b"\xb0\x2a\x7f") == [(1, 42, 127)]


def test_a_system_message_ends_running_status() -> None:
    assert found(b"\xb0\x2a\x7f\xf3\x01\x2b\x7f") == [(1, 42, 127)]


def test_a_message_that_is_cut_short_is_dropped() -> None:
    assert found(bytes([0xB0, 42, 0xB0, 43, 127])) == [(1, 43, 127)]


SEVEN = st.integers(0, 127)
MESSAGES = st.lists(
    st.one_of(
        st.builds(ControlChange, st.integers(1, 16), SEVEN, SEVEN),
        st.builds(lambda kind, a, b: bytes([kind, a, b]), st.integers(0x80, 0xAF), SEVEN, SEVEN),
        st.builds(lambda n, a: bytes([0xC0 | n, a]), st.integers(0, 31), SEVEN),
        st.builds(lambda body: b"\xf0" + bytes(body) + b"\xf7", st.lists(SEVEN, max_size=6)),
    ),
    max_size=12,
)


@given(MESSAGES, st.integers(0, 2**32))
def test_what_was_sent_is_found(messages: list[ControlChange | bytes], seed: int) -> None:
    """However it is sent: with or without running status, with a clock in between, in pieces."""
    chance = random.Random(seed)
    data, running = bytearray(), -1
    for each in messages:
        if isinstance(each, bytes):
            data += each
            running = -1
            continue
        status = 0xB0 + each.channel - 1
        if running != status or chance.random() < 0.5:
            data.append(status)
        data += bytes([each.number, each.value])
        running = status
    with_clock = bytearray()
    for byte in data:
        with_clock += bytes(chance.randrange(0xF8, 0x100) for _ in range(chance.choice([0, 0, 1])))
        with_clock.append(byte)
    parser, got = ControlChangeParser(), []
    while with_clock:
        size = chance.randint(1, 5)
        got += parser.take(bytes(with_clock[:size]))
        del with_clock[:size]

    assert got == [each for each in messages if isinstance(each, ControlChange)]


def test_a_million_random_bytes_give_only_values_in_range() -> None:
    chance = random.Random(14)
    data = chance.randbytes(1_000_000)

    changes = found(data)

    assert len(changes) > 1_000
    assert {each.channel for each in changes} == set(range(1, 17))
    assert all(0 <= each.number <= 127 and 0 <= each.value <= 127 for each in changes)
    parser, again = ControlChangeParser(), []
    for start in range(0, 100_000, 997):
        again += parser.take(data[start : start + 997])
    assert again == changes[: len(again)]
    assert len(again) > 100
