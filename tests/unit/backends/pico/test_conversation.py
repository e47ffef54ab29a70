"""What is said to a device of which not everything is heard."""

from __future__ import annotations

import struct

from pirate_sm.backends.pico.conversation import Conversation, Wanted
from pirate_sm.backends.pico.framing import Decoder, encode
from pirate_sm.backends.pico.topics import PUBLISHER, TIME

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
