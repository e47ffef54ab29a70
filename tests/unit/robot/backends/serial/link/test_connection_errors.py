"""What is said where a connection fails."""

from __future__ import annotations

import struct

import pytest

from pirate_sm.robot.backends.serial.link.conversation import (
    Conversation,
    Wanted,
    difference,
    mute,
    no_sensors,
    unanswered,
)
from pirate_sm.robot.rosserial.frames import PUBLISHER, TopicInfo, encode

STATE = Wanted("state", "some_msgs/State", "0" * 32, "publishes", "int16 value")
TAKES = Wanted("setpoints", "some_msgs/Setpoints", "1" * 32, "takes")


def said(sample: bytes, usual_baud: int | None = None, baud: int = 57_600) -> str:
    return unanswered("PORT", baud, Conversation([STATE], now=0.0), sample, usual_baud)


@pytest.mark.parametrize("usual_baud", [None, 57_600])
def test_where_nothing_comes_at_the_usual_rate_the_port_and_the_power_are_asked_about(
    usual_baud: int | None,
) -> None:
    assert said(b"", usual_baud).startswith("nothing answers on PORT at 57600 baud: is this the")


def test_where_nothing_comes_at_another_rate_than_the_profiles_that_is_said() -> None:
    assert said(b"", 115_200) == (
        "nothing answers on PORT at 57600 baud: the robot's profile says that its firmware speaks "
        "115200"
    )
    assert "another speed" in said(b"\0\xff\x80", 115_200)


@pytest.mark.parametrize(
    ("sample", "shown"),
    [
        (b"$GPGGA,1234 ~", "$GPGGA,1234 ~"),
        (b"a\tb\r\nc\xff" + b" " * 3, "a b c\ufffd"),
        (b"x" * 50, "x" * 40),
    ],
)
def test_another_device_that_sends_text_is_shown_by_it(sample: bytes, shown: str) -> None:
    assert said(sample) == f"PORT does not speak rosserial, it sends '{shown}': another device?"


@pytest.mark.parametrize("sample", [b"abcd\xff", b"abcd\x7f", b"abcd\x1f", b"abcd\0"])
def test_what_is_text_for_less_than_nine_in_ten_bytes_makes_no_sense(sample: bytes) -> None:
    assert said(sample) == (
        "PORT sends bytes that make no sense at 57600 baud: the firmware uses another speed "
        "(option baud), or it is another device"
    )


def introduction(wanted: Wanted) -> bytes:
    words = (wanted.name, wanted.type, wanted.md5)
    texts = b"".join(struct.pack("<I", len(word)) + word.encode() for word in words)
    return encode(PUBLISHER, struct.pack("<H", 125) + texts + struct.pack("<i", 512))


def test_a_device_that_lacks_a_topic_is_asked_for_it_and_what_it_offers_is_shown() -> None:
    conversation = Conversation([STATE, TAKES], now=0.0)
    list(conversation.receive(introduction(STATE) * 2, 0.1))

    assert unanswered("PORT", 57_600, conversation, b"") == (
        "the device on PORT speaks rosserial but does not announce setpoints (some_msgs/Setpoints, "
        "which it takes). It offers state (some_msgs/State, which it publishes): put its names and "
        "types into section 'serial' of the robot's profile"
    )


def test_a_device_that_offers_nothing_yet_is_said_to() -> None:
    conversation = Conversation([STATE], now=0.0)
    list(conversation.receive(encode(PUBLISHER, b"?"), 0.1))

    assert "does not announce state" in unanswered("PORT", 57_600, conversation, b"")
    assert "It offers no topic at all:" in unanswered("PORT", 57_600, conversation, b"")


def test_another_type_and_another_definition_of_the_same_type_are_told_apart() -> None:
    info = TopicInfo(125, "state", "some_msgs/Other", "2" * 32, 512, "publishes")

    assert difference(STATE, info) == (
        "the device says that topic 'state' carries some_msgs/Other, the robot's profile says "
        "some_msgs/State"
    )
    of_our_type = difference(STATE, info._replace(type=STATE.type))
    assert of_our_type.startswith(
        "the firmware's some_msgs/State is another one than ours: its md5"
    )
    assert of_our_type.endswith("which is:\nint16 value")


def test_boards_that_report_nothing_are_named_with_what_to_do() -> None:
    assert no_sensors("") == (
        "the robot's controller answers but no board sends any value: are the sensors switched on, "
        "are the boards powered?"
    )
    assert no_sensors("press the green key").endswith("sends any value: press the green key")
    modules = {12: "front", 3: "rear", 4: "middle"}
    assert mute(modules, [12, 3]) == "no values come from board 3 (rear), 12 (front)"
