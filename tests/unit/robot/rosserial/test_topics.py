"""The payloads of the reserved topics, held to captured ones."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.robot.rosserial.frames import (
    PUBLISHER,
    SUBSCRIBER,
    LogLine,
    TopicInfo,
    log_payload,
    read_log,
    read_topic,
    time_payload,
    topic_payload,
)

from . import captured

STATE = TopicInfo(
    125, "state", "pirate_msgs/State", "704cdcb7b128fe0240339af8c705abae", 512, "publishes"
)
ARRAY = TopicInfo(
    100,
    "setpoint_array",
    "pirate_msgs/Setpoint_Array",
    "91cb216cb01faeb36bf37f6896af1aea",
    512,
    "takes",
)


@pytest.mark.parametrize(
    ("frame", "info"), [(captured.PUBLISHER, STATE), (captured.SUBSCRIBER, ARRAY)]
)
def test_a_topic_is_introduced_as_captured(frame: captured.Captured, info: TopicInfo) -> None:
    payload = bytes.fromhex(frame.payload)

    assert topic_payload(info) == payload
    assert read_topic(frame.topic, payload) == info


def test_a_log_line_is_written_and_read_as_it_was_captured() -> None:
    payload = bytes.fromhex(captured.LOG.payload)

    assert log_payload(LogLine(1, "bay ready")) == payload
    assert read_log(payload) == LogLine(1, "bay ready")


def test_the_time_is_told_in_seconds_and_nanoseconds() -> None:
    payload = bytes.fromhex(captured.TIME_REPLY.payload)
    seconds, nanoseconds = struct.unpack("<II", payload)

    assert time_payload(seconds + 0.5) == payload[:4] + struct.pack("<I", 500_000_000)
    told = struct.unpack("<II", time_payload(seconds + nanoseconds / 1e9))
    assert told == (seconds, pytest.approx(nanoseconds, abs=1e3))


def introduced(**other: object) -> bytes:
    return topic_payload(STATE._replace(**other))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        b"\x7d",
        introduced()[:-1],
        introduced() + b"\0",
        introduced(number=99),
        introduced(buffer_bytes=0),
        introduced(name="stäte").replace("ä".encode(), b"\xff\xff"),
        introduced()[:2] + b"\xff\xff\xff\xff" + introduced()[6:],
    ],
    ids=[
        *("empty", "one byte", "too short", "too long", "a reserved number", "no room"),
        *("no text", "a text longer than the payload"),
    ],
)
def test_what_is_no_introduction_is_ignored(payload: bytes) -> None:
    assert read_topic(PUBLISHER, payload) is None


def test_a_topic_may_have_room_for_a_single_byte() -> None:
    assert read_topic(PUBLISHER, introduced(buffer_bytes=1)) == STATE._replace(buffer_bytes=1)


def test_a_name_has_no_leading_slash() -> None:
    assert read_topic(SUBSCRIBER, introduced(name="/state")) == STATE._replace(direction="takes")


@given(st.binary(max_size=80))
def test_any_payload_is_read_or_ignored(payload: bytes) -> None:
    for found in (read_topic(PUBLISHER, payload), read_log(payload)):
        assert found is None or found


@pytest.mark.parametrize("payload", [b"", b"\x01", b"\x01\x02\0\0\0x", b"\x01\x01\0\0\0xy"])
def test_what_is_no_line_of_the_log_is_ignored(payload: bytes) -> None:
    assert read_log(payload) is None
