"""A frame is written when the ring of the device has room for it, and no sooner."""

from __future__ import annotations

import pytest

from pirate_sm.robot.backends.serial.link.link_plan import RING_BYTES, Throttle

BYTE_S = 0.001
READ_S = 0.020
"""The device reads its ring this often."""


@pytest.fixture
def throttle() -> Throttle:
    return Throttle(baud=10_000)


def test_while_there_is_room_nothing_waits(throttle: Throttle) -> None:
    throttle.wrote(RING_BYTES - 10, now=1.0)

    assert throttle.free_s(10, now=1.0) == 1.0
    assert throttle.free_s(11, now=1.0) > 1.0


def test_the_first_frame_must_have_arrived_and_been_read_before_the_next(
    throttle: Throttle,
) -> None:
    throttle.wrote(RING_BYTES, now=1.0)
    read_s = 1.0 + RING_BYTES * BYTE_S + READ_S

    assert throttle.free_s(1, now=1.0) == pytest.approx(read_s)
    assert throttle.free_s(1, now=read_s) == read_s
    assert throttle.free_s(RING_BYTES, now=read_s + 1.0) == read_s + 1.0


def test_of_several_frames_only_those_are_awaited_whose_room_is_needed(throttle: Throttle) -> None:
    throttle.wrote(30, now=1.0)
    throttle.wrote(30, now=1.0)
    first_s, second_s = 1.0 + 30 * BYTE_S + READ_S, 1.0 + 60 * BYTE_S + READ_S

    assert throttle.free_s(4, now=1.0) == 1.0
    assert throttle.free_s(34, now=1.0) == pytest.approx(first_s)
    assert throttle.free_s(35, now=1.0) == pytest.approx(second_s)


def test_a_frame_that_is_longer_than_the_ring_waits_for_an_empty_one(throttle: Throttle) -> None:
    assert throttle.free_s(3 * RING_BYTES, now=1.0) == 1.0
    throttle.wrote(1, now=1.0)

    assert throttle.free_s(3 * RING_BYTES, now=1.0) == pytest.approx(1.0 + BYTE_S + READ_S)


def test_frames_that_are_written_one_after_the_other_share_the_line(throttle: Throttle) -> None:
    throttle.wrote(10, now=1.0)
    throttle.wrote(10, now=1.005)  # the line is still busy with the first
    throttle.wrote(44, now=2.0)  # the line is free

    assert throttle.free_s(RING_BYTES, now=1.005) == pytest.approx(2.0 + 44 * BYTE_S + READ_S)
    assert throttle.free_s(20, now=1.005) == pytest.approx(1.0 + 20 * BYTE_S + READ_S)


def test_a_device_that_is_busy_after_a_frame_reads_later(throttle: Throttle) -> None:
    throttle.wrote(RING_BYTES, now=1.0, busy_s=0.5)

    read_s = 1.5 + RING_BYTES * BYTE_S + READ_S
    assert throttle.free_s(1, now=1.0) == pytest.approx(read_s)


def test_arrays_take_a_sixth_of_the_line(throttle: Throttle) -> None:
    assert throttle.spacing_s(50) == pytest.approx(6 * 50 * BYTE_S)
