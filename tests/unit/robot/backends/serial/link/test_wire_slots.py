"""Setpoints as integers: what must not be sent, and what the safe array makes of the others."""

from __future__ import annotations

from math import inf, nan

import pytest

from pirate_sm.core.loading import load_robot
from pirate_sm.robot.backends.serial.link.link_plan import WireSlot, to_counts, why_refused
from pirate_sm.robot.backends.serial.link.recovery import SafeArray
from pirate_sm.robot.rosserial.messages import SetpointCodec, read_messages, serial_of

from ..conftest import SIX_WHEELED

SLOTS = (WireSlot("motor", 0.001, 1.0), WireSlot("angle", 0.01, 2.5))


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ((1.0, -2.5), ""),
        ((1.0 + 1e-7, -2.5 - 1e-7), ""),
        ((1.001, 0.0), "motor = 1.001 is beyond its limit of 1"),
        ((0.0, -2.6), "angle = -2.6 is beyond its limit of 2.5"),
        ((nan, 0.0), "motor is no number"),
        ((0.0, inf), "angle is no number"),
        ((0.0,), "1 values for 2 slots"),
        ((0.0, 0.0, 0.0), "3 values for 2 slots"),
    ],
)
def test_only_numbers_within_the_limits_are_sent(values: tuple[float, ...], why: str) -> None:
    assert why_refused(SLOTS, values) == why


def test_values_are_written_in_the_resolution_of_their_slot() -> None:
    assert to_counts(SLOTS, (0.5004, -1.236)) == (500, -124)


@pytest.fixture
def codec() -> SetpointCodec:
    """The arrays of the shipped robot, whose echo shows the mask of the switch."""
    profile = load_robot(SIX_WHEELED).profile
    serial = serial_of(profile)
    return read_messages(SIX_WHEELED / serial.messages, serial, len(profile.slots)).setpoints


def test_the_safe_array_stops_what_it_must_and_holds_everything_else(codec: SetpointCodec) -> None:
    safe, count = SafeArray(codec, {0, 2}, 18), 18
    in_force = tuple(range(5, 5 + count))

    array = codec.unpack(safe.payload(in_force))

    assert array.number == 0
    assert array.counts == safe.counts == (0, 6, 0, *range(8, 5 + count))
    assert safe.kept == (1 << count) - 1 - 0b101


def test_the_safe_array_follows_the_array_in_force_until_other_values_are_to_be_held(
    codec: SetpointCodec,
) -> None:
    safe = SafeArray(codec, {0}, 18)
    first, second, held = ((each,) * 18 for each in (1, 2, 3))
    assert codec.unpack(safe.payload(first)).counts == (0, *first[1:])
    assert codec.unpack(safe.payload(second)).counts == (0, *second[1:])

    safe.held = held

    assert codec.unpack(safe.payload(second)).counts == (0, *held[1:])
    assert safe.payload(second) is safe.payload(first), "it is needed often, and packed once"
