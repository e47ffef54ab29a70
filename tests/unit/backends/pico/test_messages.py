"""The `.msg` texts of a robot: sums, layouts, and what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.backends.pico.messages import Malformed, Messages, read_messages
from pirate_sm.backends.pico.plan import Plan
from pirate_sm.errors import UsageError
from pirate_sm.model.wire import Serial

ARRAY = "uint32 id\nint16[18] setpoints"
STATE = "uint8 board\nfloat32[9] values"


def read(folder: Path, serial: Serial, *, array: str = ARRAY, state: str = STATE) -> Messages:
    for name, text in (("Setpoint_Array", array), ("Setpoint_Echo", ARRAY), ("State", state)):
        (folder / f"{name}.msg").write_bytes(text.encode())
    return read_messages(folder, serial, 18)


def test_the_sum_is_that_of_ros_whatever_ends_the_lines(tmp_path: Path, plan: Plan) -> None:
    text = "# which\r\nuint32 id   # of the array\r\n\r\nint16[18] setpoints\r\n"
    messages = read(tmp_path, plan.serial, array=text)

    assert messages.setpoints.type.md5 == "91cb216cb01faeb36bf37f6896af1aea"


def test_an_array_is_written_as_it_was_captured(plan: Plan) -> None:
    counts = (1, -1, *[0] * 15, 1001)
    payload = plan.messages.setpoints.pack(2, counts)

    assert payload.hex() == "020000000100ffff" + "00" * 30 + "e903"
    assert plan.messages.echo.unpack(payload)[:2] == (2, counts)


@given(st.binary(max_size=80))
def test_any_payload_is_read_or_refused(plan: Plan, payload: bytes) -> None:
    for codec in (plan.messages.echo, plan.messages.state):
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
        ({"array": f"{ARRAY}\nuint8 mode"}, "nobody knows what to put into mode"),
        ({"array": "uint32[2] id\nint16[18] setpoints"}, "'id' must be one integer"),
        ({"array": "not a definition at all"}, "Setpoint_Array.msg: "),
        ({"state": "uint8 board\nfloat32 values"}, "'values' must be an array"),
        ({"state": "string board\nfloat32[9] values"}, "'board' holds no numbers"),
    ],
)
def test_a_text_that_does_not_fit_is_told_by_name(
    tmp_path: Path, plan: Plan, texts: dict[str, str], message: str
) -> None:
    with pytest.raises(UsageError, match=message.replace("[", r"\[")):
        read(tmp_path, plan.serial, **texts)


def test_a_missing_text_is_asked_for(tmp_path: Path, plan: Plan) -> None:
    with pytest.raises(UsageError, match="put the text of pirate_msgs/Setpoint_Array from your"):
        read_messages(tmp_path, plan.serial, 18)
