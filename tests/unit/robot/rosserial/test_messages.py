"""The `.msg` texts of a robot: sums, layouts, and what is wrong with them."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Serial, SetpointTopic, StateTopic
from pirate_sm.robot.rosserial.message_types import Malformed
from pirate_sm.robot.rosserial.messages import (
    Array,
    Messages,
    SetpointCodec,
    StateReading,
    link_messages,
    read_messages,
)

from . import captured

ARRAY = "uint32 id\nint16[18] setpoints"
STATE = "uint8 board\nfloat32[9] values"


def read(folder: Path, serial: Serial, *, array: str = ARRAY, state: str = STATE) -> Messages:
    for name, text in (("Setpoint_Array", array), ("Setpoint_Echo", ARRAY), ("State", state)):
        (folder / f"{name}.msg").write_bytes(text.encode())
    return read_messages(folder, serial, 18)


def test_the_sum_is_that_of_ros_whatever_ends_the_lines(tmp_path: Path, serial: Serial) -> None:
    text = "# which\r\nuint32 id   # of the array\r\n\r\nint16[18] setpoints\r\n"
    messages = read(tmp_path, serial, array=text)

    assert messages.setpoints.type.md5 == "91cb216cb01faeb36bf37f6896af1aea"


def test_an_array_and_its_echo_are_the_captured_ones(messages: Messages) -> None:
    counts = (1, -1, *[0] * 15, 1001)

    for codec, frame in ((messages.setpoints, captured.ARRAY), (messages.echo, captured.ECHO)):
        assert codec.pack(2, counts).hex() == frame.payload
        assert codec.unpack(bytes.fromhex(frame.payload)) == Array(2, counts, 0)


def one_value(serial: Serial) -> Messages:
    """The same link, with one value in each State message."""
    by_value = serial.model_copy(
        update={"state": serial.state.model_copy(update={"layout": "value"})}
    )
    state = "uint8 board\nuint8 channel\nfloat32 value"
    texts = {serial.setpoints.type: ARRAY, serial.echo.type: ARRAY, serial.state.type: state}
    return link_messages(texts, by_value, 18)


def test_one_value_is_written_and_read_as_it_was_captured(serial: Serial) -> None:
    codec, reading = one_value(serial).state, StateReading(4, 3, (403.0,))

    assert codec.pack(reading).hex() == captured.STATE.payload
    assert codec.unpack(bytes.fromhex(captured.STATE.payload)) == reading


def test_a_board_with_fewer_channels_than_the_message_has_is_filled_up_with_zeros(
    messages: Messages,
) -> None:
    payload = messages.state.pack(StateReading(7, -1, (1.5, 2.0)))

    assert payload == struct.pack("<B9f", 7, 1.5, 2.0, *[0.0] * 7)
    assert messages.state.unpack(payload) == StateReading(7, -1, (1.5, 2.0, *[0.0] * 7))


def test_only_the_host_wants_a_payload_to_end_with_the_array(messages: Messages) -> None:
    buffer = bytes.fromhex(captured.ARRAY.payload) + b"what came before"

    assert messages.setpoints.unpack(buffer, whole=False).number == 2
    with pytest.raises(Malformed):
        messages.setpoints.unpack(buffer)


def test_the_switch_leaves_what_is_held() -> None:
    assert Array(1, (5, 6, 7), 0b101).tripped == Array(1, (5, 0, 7), 0b101)
    assert Array(1, (5, 6, 7)).tripped.counts == (0, 0, 0)


@given(st.binary(max_size=80))
def test_any_payload_is_read_or_refused(messages: Messages, payload: bytes) -> None:
    for codec in (messages.echo, messages.state):
        try:
            codec.unpack(payload)
        except Malformed:
            continue


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        ({"array": "uint32 number\nint16[18] setpoints"}, "has no field 'id', only number"),
        ({"array": "uint32 id\nint16[17] setpoints"}, "must be 18 integers"),
        ({"array": "uint32 id\nfloat32[18] setpoints"}, "must be 18 integers"),
        ({"array": f"{ARRAY}\nuint8 mode"}, "it is unknown what to put into mode"),
        ({"array": "uint32[2] id\nint16[18] setpoints"}, "'id' must be one integer"),
        ({"array": "float32 id\nint16[18] setpoints"}, "'id' must be one integer"),
        ({"array": "not a definition at all"}, "Setpoint_Array.msg: "),
        ({"state": "uint8 board\nfloat32 values"}, "'values' must be an array"),
        ({"state": "string board\nfloat32[9] values"}, "'board' holds no numbers"),
    ],
)
def test_a_text_that_does_not_fit_is_told_by_name(
    tmp_path: Path, serial: Serial, texts: dict[str, str], message: str
) -> None:
    with pytest.raises(UsageError, match=message.replace("[", r"\[")):
        read(tmp_path, serial, **texts)


def test_a_missing_text_is_asked_for(tmp_path: Path, serial: Serial) -> None:
    with pytest.raises(UsageError, match="put the text of pirate_msgs/Setpoint_Array from your"):
        read_messages(tmp_path, serial, 18)


# --- what the firmware's dead man's switch keeps ------------------------------------------------


def codec(tmp_path: Path, text: str, hold: str, slots: int = 3) -> SetpointCodec:
    (tmp_path / "Go.msg").write_text(text)
    (tmp_path / "Is.msg").write_text("uint8 board\nfloat32[1] values")
    topic = {"topic": "go", "type": "a/Go", "hold": hold}
    serial = Serial(
        baud=57600,
        boot=1.0,
        echo_within=0.1,
        heartbeat_within=0.3,
        setpoints=SetpointTopic(**topic),
        echo=SetpointTopic(**topic),
        state=StateTopic(topic="is", type="a/Is", layout="board"),
    )
    return read_messages(tmp_path, serial, slots).setpoints


GO = "uint32 id\nint16[3] setpoints"


def test_the_mask_is_the_upper_bits_of_the_id(tmp_path: Path) -> None:
    go = codec(tmp_path, GO, "id")
    payload = go.pack(5, (1, 2, 3), hold=0b101)

    assert int.from_bytes(payload[:4], "little") == 0b101 << 29 | 5
    assert go.unpack(payload) == Array(5, (1, 2, 3), 0b101)
    assert go.ids == 1 << 29


def test_the_mask_is_a_field_of_its_own(tmp_path: Path) -> None:
    go = codec(tmp_path, GO + "\nuint8 keep", "keep")
    payload = go.pack(5, (1, 2, 3), hold=0b101)

    assert payload[-1] == 0b101
    assert go.unpack(payload) == Array(5, (1, 2, 3), 0b101)
    assert go.ids == 1 << 32


def test_a_message_without_a_mask_leaves_it_out(tmp_path: Path) -> None:
    go = codec(tmp_path, GO, "")

    assert go.pack(5, (1, 2, 3), hold=0b101) == go.pack(5, (1, 2, 3))
    assert go.unpack(go.pack(5, (1, 2, 3))) == Array(5, (1, 2, 3), None)


@pytest.mark.parametrize(
    ("text", "hold", "slots", "message"),
    [
        (GO, "keep", 3, "has no field 'keep'"),
        (
            GO.replace("[3]", "[25]"),
            "id",
            25,
            "32 bits, and the mask of 25 slots needs 33, 8 of them",
        ),
        (
            GO.replace("[3]", "[9]") + "\nuint8 keep",
            "keep",
            9,
            "'keep' has 8 bits, and the mask of 9",
        ),
        (GO + "\nint32 keep", "keep", 3, "'keep' must be one unsigned integer"),
    ],
)
def test_a_mask_that_does_not_fit_is_told_with_what_it_needs(
    tmp_path: Path, text: str, hold: str, slots: int, message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        codec(tmp_path, text, hold, slots)
