from __future__ import annotations

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.robot.rosserial.message_types import Malformed, MessageType, message_types

SETPOINTS = "uint32 id\nint16[18] setpoints"
VALUE = "uint8 board\nuint8 channel\nfloat32 value"


def kind(text: str, name: str = "some_msgs/It") -> MessageType:
    return message_types([name], {name: text})[name]


@pytest.mark.parametrize(
    ("text", "md5"),
    [
        (SETPOINTS, "91cb216cb01faeb36bf37f6896af1aea"),
        (SETPOINTS.replace("\n", "\r\n"), "91cb216cb01faeb36bf37f6896af1aea"),
        (VALUE, "704cdcb7b128fe0240339af8c705abae"),
        (f"# what a board says\n\n{VALUE}  # raw\n", "704cdcb7b128fe0240339af8c705abae"),
        ("string data", "992ce8a1687cec8c8bd883ec73ca41d1"),
        (
            "uint16 ID_PUBLISHER=0\nuint16 ID_SUBSCRIBER=1\nuint16 ID_SERVICE_SERVER=2\n"
            "uint16 ID_SERVICE_CLIENT=4\nuint16 ID_PARAMETER_REQUEST=6\nuint16 ID_LOG=7\n"
            "uint16 ID_TIME=10\nuint16 ID_TX_STOP=11\nuint16 topic_id\nstring topic_name\n"
            "string message_type\nstring md5sum\nint32 buffer_size",
            "0ad51f88fc44892f8c10684077646005",
        ),
    ],
)
def test_the_md5_is_that_of_ros(text: str, md5: str) -> None:
    assert kind(text).md5 == md5


def test_a_value_is_packed_as_captured() -> None:
    raw = kind(VALUE).pack({"board": 4, "channel": 3, "value": 403.0})

    assert raw.hex() == "04030080c943"


@pytest.mark.parametrize("value", [300, 300.0, 254.6, 255])
def test_what_an_integer_cannot_hold_becomes_the_nearest_that_it_can(value: float) -> None:
    assert kind("uint8[] values").pack({"values": [value]}) == b"\x01\0\0\0\xff"
    assert kind("uint8 value").pack({"value": value}) == b"\xff"


def test_what_is_not_named_is_zero() -> None:
    it = kind("std_msgs/Header header\nuint8 board\nfloat32[4] values\nstring note\nint16[] more")

    raw = it.pack({"board": 7, "values": [1.0], "more": [1e9]})

    header = bytes(16)
    assert raw == header + b"\x07\x00\x00\x80\x3f" + bytes(12) + bytes(4) + (
        b"\x01\x00\x00\x00\xff\x7f"
    )


def test_arrays_that_are_not_named_are_zero_or_empty() -> None:
    it = kind("int16[] more\nint16[2] numbers\nstring[2] notes")

    assert it.pack({}) == bytes(4) + bytes(2 * 2) + bytes(2 * 4)


def test_a_message_is_read_from_the_beginning_of_a_longer_buffer_only_where_that_is_asked() -> None:
    it, buffer = kind("uint32 id\nint16[2] setpoints"), b"\x05\0\0\0\x01\0\xff\xffrest"

    message = it.unpack(buffer, whole=False)
    assert (message.id, message.setpoints.tolist()) == (5, [1, -1])
    with pytest.raises(Malformed, match="12 bytes, not 8"):
        it.unpack(buffer)


def test_bytes_that_are_no_such_message_are_reported() -> None:
    with pytest.raises(Malformed):
        kind("uint32 id\nint16[] setpoints").unpack(b"\0\0\0\0\xff\xff\xff\x0f", whole=False)


@pytest.mark.parametrize(
    ("text", "largest"),
    [(SETPOINTS, 40), (VALUE, 6), ("int16[] to", None), ("string note", None)],
)
def test_the_longest_payload_is_known_where_no_field_holds_any_count(
    text: str, largest: int | None
) -> None:
    assert kind(text).largest == largest


@pytest.mark.parametrize("text", ["float32[9 values", "other_msgs/Unknown x"])
def test_a_text_that_is_none_is_refused_with_its_type(text: str) -> None:
    with pytest.raises(UsageError, match=r"It\.msg"):
        kind(text)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({"nothing": 1.0}, "no field 'nothing'"),
        ({"note": 1.0}, "holds no numbers"),
        ({"values": [1.0, 2.0, 3.0]}, "'values' holds 2 numbers, not 3"),
    ],
)
def test_content_that_does_not_fit_is_refused(content: dict[str, object], says: str) -> None:
    with pytest.raises(UsageError, match=says):
        kind("float32[2] values\nstring note").pack(content)  # type: ignore[arg-type]
