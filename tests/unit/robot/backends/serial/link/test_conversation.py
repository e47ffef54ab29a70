"""What is said to a device of which not everything is heard."""

from __future__ import annotations

import struct

import pytest

from pirate_sm.robot.backends.serial.link.conversation import Conversation, TopicRefused, Wanted
from pirate_sm.robot.rosserial.frames import (
    PUBLISHER,
    REQUEST_TOPICS,
    SUBSCRIBER,
    TIME,
    Decoder,
    encode,
)

STATE = Wanted("state", "some_msgs/State", "0" * 32, "publishes")
NUMBER = 125


def introduction() -> bytes:
    words = (STATE.name, STATE.type, STATE.md5)
    texts = b"".join(struct.pack("<I", len(word)) + word.encode() for word in words)
    return encode(PUBLISHER, struct.pack("<H", NUMBER) + texts + struct.pack("<i", 512))


def test_the_time_is_told_though_the_devices_first_request_was_lost() -> None:
    conversation = Conversation([STATE], now=0.0)
    assert list(conversation.receive(introduction() * 2, 0.1))
    assert conversation.known

    told: list[float] = []
    for turn in range(100):
        now = 0.1 + turn / 20
        list(conversation.receive(encode(NUMBER, b"\1"), now))
        said = Decoder().feed(conversation.write(now))
        told += [now for frame in said if frame.topic == TIME]

    assert told[0] < 0.2
    assert len(told) > 3, "and again, since that may be lost too"


TAKES = Wanted("setpoints", "some_msgs/Setpoints", "1" * 32, "takes")
TAKEN = 100


def offer(wanted: Wanted, number: int, room: int) -> bytes:
    texts = b"".join(
        struct.pack("<I", len(word)) + word.encode()
        for word in (wanted.name, wanted.type, wanted.md5)
    )
    return encode(SUBSCRIBER, struct.pack("<H", number) + texts + struct.pack("<i", room))


def test_one_damaged_introduction_does_not_change_the_length_that_a_device_has_room_for() -> None:
    conversation = Conversation([TAKES], now=0.0)
    list(conversation.receive(offer(TAKES, TAKEN, 64) * 2, 0.1))
    assert conversation.frame(0, bytes(64))

    list(conversation.receive(offer(TAKES, TAKEN, 0x10040), 0.2))  # one byte of it is damaged

    assert conversation.frame(0, bytes(64))
    assert not conversation.frame(0, bytes(65)), "it would overrun the device's memory"


def test_one_damaged_introduction_does_not_change_the_number_of_a_topic() -> None:
    conversation = Conversation([TAKES], now=0.0)
    list(conversation.receive(offer(TAKES, TAKEN, 64) * 2, 0.1))

    list(conversation.receive(offer(TAKES, TAKEN + 1, 64), 0.2))

    [frame] = Decoder().feed(conversation.frame(0, b"x"))
    assert frame.topic == TAKEN


def test_one_damaged_introduction_does_not_refuse_a_topic_that_is_known() -> None:
    conversation = Conversation([TAKES], now=0.0)
    list(conversation.receive(offer(TAKES, TAKEN, 64) * 2, 0.1))
    damaged = offer(TAKES._replace(md5="0" + TAKES.md5[1:]), TAKEN, 64)

    assert list(conversation.receive(damaged, 0.2)) == []
    [refused] = conversation.receive(damaged, 0.3)
    assert isinstance(refused, TopicRefused), "what comes twice is no damage"


def short_frames() -> Conversation:
    """A conversation whose topics are known; nothing longer than 37 bytes is expected."""
    conversation = Conversation([STATE._replace(longest=37)], now=0.0)
    list(conversation.receive(introduction() * 2, 0.1))
    assert conversation.known
    return conversation


def test_a_damaged_length_beyond_what_can_come_withholds_no_good_frame() -> None:
    conversation = short_frames()
    head = encode(NUMBER, bytes(500))[:5]  # a frame of 37 bytes whose length says 500

    heard = list(conversation.receive(head + encode(NUMBER, b"after"), 0.2))

    assert [each.payload for each in heard] == [b"after"]


def test_an_introduction_may_be_long_while_the_device_is_being_asked() -> None:
    conversation = Conversation([STATE._replace(longest=37)], now=0.0)
    other = STATE._replace(name="n" * 300)
    texts = b"".join(
        struct.pack("<I", len(word)) + word.encode() for word in (other.name, other.type, other.md5)
    )
    long = encode(PUBLISHER, struct.pack("<H", 126) + texts + struct.pack("<i", 512))

    list(conversation.receive(long, 0.1))

    assert ("publishes", other.name) in conversation.offered


def test_a_device_with_more_topics_than_are_wanted_may_send_anything() -> None:
    conversation = Conversation([STATE._replace(longest=37)], now=0.0)
    frame = Decoder().feed(introduction())[0].payload.replace(b"state", b"image")
    more = encode(PUBLISHER, frame)
    list(conversation.receive(more * 2 + introduction() * 2, 0.1))
    assert conversation.known
    dropped = conversation.dropped

    list(conversation.receive(encode(130, bytes(400)) + encode(NUMBER, b"x"), 0.2))

    assert conversation.dropped == dropped


def test_an_echo_alone_does_not_end_a_silence() -> None:
    echo = Wanted("echo", "some_msgs/Setpoints", "2" * 32, "publishes", answers=True)
    conversation = Conversation([STATE, echo], now=0.0)
    texts = b"".join(
        struct.pack("<I", len(word)) + word.encode() for word in (echo.name, echo.type, echo.md5)
    )
    offered = encode(PUBLISHER, struct.pack("<H", 126) + texts + struct.pack("<i", 512))
    list(conversation.receive((introduction() + offered) * 2, 0.1))
    assert conversation.known
    for turn in range(1, 6):
        list(conversation.receive(encode(126, b"x"), 0.1 + turn / 10))
        conversation.write(0.1 + turn / 10)

    assert conversation.asking


def quiet_until(conversation: Conversation, since_s: float, until_s: float) -> list[float]:
    """When the device was asked for its topics, as nothing came from it meanwhile."""
    asked, now = [], since_s
    while now < until_s:
        now = min(conversation.due_s, until_s)
        if conversation.write(now) == encode(REQUEST_TOPICS):
            asked.append(now)
    return asked


def test_a_device_is_asked_once_it_was_silent_while_this_program_was_awake() -> None:
    conversation = short_frames()
    list(conversation.receive(encode(NUMBER, b"x"), 1.0))

    assert quiet_until(conversation, 1.0, 2.0)[0] == pytest.approx(1.4, abs=0.01)


def test_a_standstill_of_this_program_is_not_counted_as_silence_of_the_device() -> None:
    conversation = short_frames()
    list(conversation.receive(encode(NUMBER, b"x"), 1.0))

    assert conversation.write(2.2) != encode(REQUEST_TOPICS)
    assert quiet_until(conversation, 2.2, 3.0)[0] == pytest.approx(2.6, abs=0.01)


def test_after_each_request_the_time_is_told_three_times() -> None:
    conversation = short_frames()
    told: list[float] = []
    for turn in range(300):
        now = 1.0 + turn / 100
        list(conversation.receive(encode(TIME) if turn in {0, 50} else encode(NUMBER, b"x"), now))
        said = Decoder().feed(conversation.write(now))
        told += [now for frame in said if frame.topic == TIME]

    assert [each for each in told if each >= 1.5] == pytest.approx([1.5, 1.9, 2.3], abs=0.011)


def test_after_a_silence_every_topic_is_introduced_anew() -> None:
    conversation = Conversation([STATE, TAKES], now=0.0)
    list(conversation.receive((introduction() + offer(TAKES, TAKEN, 64)) * 2, 0.1))
    assert quiet_until(conversation, 0.1, 1.0)

    list(conversation.receive(introduction() * 2, 1.0))
    assert conversation.asking
    list(conversation.receive(offer(TAKES, TAKEN, 64) * 2, 1.1))
    assert not conversation.asking


def test_an_introduction_is_no_request_for_the_time() -> None:
    conversation = short_frames()
    told: list[float] = []
    for turn in range(250):
        now = 0.2 + turn / 100
        list(conversation.receive(introduction() if turn == 150 else encode(NUMBER, b"x"), now))
        said = Decoder().feed(conversation.write(now))
        told += [now for frame in said if frame.topic == TIME]

    assert told == pytest.approx([0.2, 0.5, 0.9], abs=0.011), "of the first request"
