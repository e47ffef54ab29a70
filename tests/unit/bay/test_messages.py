from __future__ import annotations

import pytest

from pirate_sm.bay.messages import MessageType, message_types
from pirate_sm.errors import UsageError

SETPOINTS = "uint32 id\nint16[18] setpoints"
VALUE = "uint8 board\nuint8 channel\nfloat32 value"


def kind(text: str, name: str = "some_msgs/It") -> MessageType:
    return message_types({name: text})[name]


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


def test_what_is_not_named_is_zero() -> None:
    it = kind("std_msgs/Header header\nuint8 board\nfloat32[4] values\nstring note\nint16[] more")

    raw = it.pack({"board": 7, "values": [1.0], "more": [1e9]})

    header = bytes(16)
    assert raw == header + b"\x07\x00\x00\x80\x3f" + bytes(12) + bytes(4) + (
        b"\x01\x00\x00\x00\xff\x7f"
    )


def test_an_array_is_read_from_the_beginning_of_a_longer_buffer() -> None:
    it = kind("uint32 id\nint16[2] setpoints")

    assert it.unpack(b"\x05\0\0\0\x01\0\xff\xff" + b"rest", ("id", "setpoints")) == ((5,), (1, -1))


def test_bytes_that_are_no_such_message_are_told() -> None:
    assert kind("uint32 id\nint16[] setpoints").unpack(b"\0\0\0\0\xff\xff\xff\x0f", ("id",)) is None


@pytest.mark.parametrize("text", ["float32[9 values", "other_msgs/Unknown x"])
def test_a_text_that_is_none_is_refused_with_its_type(text: str) -> None:
    with pytest.raises(UsageError, match="some_msgs/It"):
        kind(text)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({"nothing": 1.0}, "no field 'nothing'"),
        ({"note": 1.0}, "holds no numbers"),
        ({"values": [1.0, 2.0, 3.0]}, "has room for 2 numbers, not for 3"),
    ],
)
def test_content_that_does_not_fit_is_refused(content: dict[str, object], says: str) -> None:
    with pytest.raises(UsageError, match=says):
        kind("float32[2] values\nstring note").pack(content)  # type: ignore[arg-type]
