"""The emulated firmware's dead man's switch: what it stops, what it keeps, and how it says so."""

from __future__ import annotations

import struct

import pytest

from pirate_sm.core.models import Pipe, Profile
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.virtual import VirtualBay

from .conftest import ECHO, SETPOINTS, SLOTS, Host, MakeBay, array, read_array

CLAMP, LOOP, WHEEL, ANGLE = 4, 6, 5, 10
"""Slots: a bend joint that holds, one that a position loop turns, a wheel, one with an angle."""

COUNTS = tuple({CLAMP: -700, LOOP: 300, WHEEL: 1000}.get(slot, 0) for slot in range(SLOTS))
STOPPED = tuple({CLAMP: -700}.get(slot, 0) for slot in range(SLOTS))
ID_BITS = 32 - SLOTS
STOP_AFTER_S, CYCLE_S = 0.5, 0.016


def held(number: int, *slots: int) -> int:
    return sum(1 << slot for slot in (*slots, ANGLE)) << ID_BITS | number


@pytest.fixture
def host(make: MakeBay) -> Host:
    host = make(dead_man=True)
    host.connect()
    return host


def test_it_stops_what_is_not_held_half_a_second_after_the_last_array(host: Host) -> None:
    host.send(SETPOINTS, array(held(1, CLAMP), *COUNTS))
    host.listen(1.0)

    [applied], [tripped, *_] = host.events("applied"), host.events("tripped")
    assert (applied.setpoint_id, applied.counts) == (1, COUNTS)
    assert (tripped.setpoint_id, tripped.counts) == (1, STOPPED)
    assert tripped.at_s - applied.at_s == pytest.approx(STOP_AFTER_S, abs=2 * CYCLE_S)
    assert [duty for duty in host.bay.duties if duty] == pytest.approx([-0.7])


def test_a_mask_without_the_slots_that_are_always_held_is_none_and_only_wheels_stop(
    host: Host,
) -> None:
    host.send(SETPOINTS, array(1, *COUNTS))
    host.listen(1.0)

    [tripped, *_] = host.events("tripped")
    assert tripped.counts == tuple(0 if slot == WHEEL else at for slot, at in enumerate(COUNTS))
    number, counts = read_array([each for each in host.heard if each.topic == ECHO][-1].payload)
    assert (number, counts) == (1, tripped.counts), "the mask is echoed as received"


def test_any_valid_array_keeps_it_from_tripping_also_the_same_one(host: Host) -> None:
    for _ in range(10):
        host.send(SETPOINTS, array(held(1, CLAMP), *COUNTS))
        host.listen(0.45)

    assert host.events("tripped") == []


def test_frames_that_are_no_arrays_do_not_keep_it_from_tripping(host: Host) -> None:
    host.send(SETPOINTS, array(held(1, CLAMP), *COUNTS))
    for _ in range(10):
        host.send(10, struct.pack("<II", 1, 2))
        host.listen(0.1)

    assert host.events("tripped")


def test_a_trip_is_echoed_with_what_is_in_force_until_an_array_comes(host: Host) -> None:
    host.send(SETPOINTS, array(held(1, CLAMP), *COUNTS))
    host.listen(1.8)
    echoes = [read_array(each.payload) for each in host.heard if each.topic == ECHO]

    number = held(1, CLAMP)
    assert echoes == [(number, COUNTS), *[(number, STOPPED)] * 3]


def test_the_next_array_is_obeyed_as_ever(host: Host) -> None:
    host.send(SETPOINTS, array(held(1, CLAMP), *COUNTS))
    host.listen(1.0)
    host.send(SETPOINTS, array(held(2, CLAMP), *COUNTS))
    host.listen(0.2)

    assert max(host.bay.duties) == 1.0


def test_before_the_first_array_there_is_nothing_to_stop(host: Host) -> None:
    host.listen(3.0)

    assert host.events("tripped") == []


def test_a_lost_host_too_is_one_that_sends_nothing(host: Host) -> None:
    host.send(SETPOINTS, array(held(1, CLAMP), *COUNTS))
    host.listen(0.1)
    host.bay.close(host.now_s)
    host.listen(1.0)

    assert [duty for duty in host.bay.duties if duty] == pytest.approx([-0.7])


@pytest.mark.parametrize("field", ["", "hold"])
def test_a_mask_in_a_field_of_its_own_and_none_at_all(
    field: str, profile: Profile, texts: dict[str, str], pipe: Pipe
) -> None:
    assert profile.serial is not None
    serial = profile.serial.model_copy(
        update={
            name: getattr(profile.serial, name).model_copy(update={"hold": field})
            for name in ("setpoints", "echo")
        }
    )
    own = {
        kind: text + (f"\nuint32 {field}" if field and "id" in text else "")
        for kind, text in texts.items()
    }
    bay = VirtualBay(profile.model_copy(update={"serial": serial}), pipe, own, Switches(), 1)
    host = Host(bay)
    host.connect()
    mask = struct.pack("<I", 1 << CLAMP | 1 << ANGLE) if field else b""
    host.send(SETPOINTS, array(1, *COUNTS) + mask)
    host.listen(1.0)

    # Without a mask the firmware knows the wheels only: what else there is goes on.
    loop = 0 if field else COUNTS[LOOP]
    [tripped, *_] = host.events("tripped")
    assert tripped.counts == tuple({CLAMP: -700, LOOP: loop}.get(slot, 0) for slot in range(SLOTS))
