from __future__ import annotations

import math

import pytest

from pirate_sm.simulation.bay.line import Inlet, Outlet

RATE = 1000.0


def test_bytes_arrive_one_after_the_other() -> None:
    inlet = Inlet(RATE, 64)
    inlet.send(b"abc", 1.0)

    assert inlet.read(1.0005) == []
    assert inlet.read(1.002) == [(ord("a"), 1.001), (ord("b"), 1.002)]
    assert inlet.read(2.0) == [(ord("c"), 1.003)]


def test_a_second_write_waits_for_the_first() -> None:
    inlet = Inlet(RATE, 64)
    inlet.send(b"a" * 10, 0.0)
    inlet.send(b"b", 0.005)

    assert inlet.read(1.0)[-1] == (ord("b"), pytest.approx(0.011))


def test_bytes_that_come_to_a_full_ring_are_lost() -> None:
    inlet = Inlet(RATE, 64)
    inlet.send(bytes(range(96)), 0.0)

    assert [byte for byte, _ in inlet.read(1.0)] == list(range(64))
    assert inlet.lost == 32


def test_a_ring_that_is_read_in_time_loses_nothing() -> None:
    inlet = Inlet(RATE, 64)
    inlet.send(bytes(range(96)), 0.0)
    found = inlet.read(0.05) + inlet.read(0.1)

    assert [byte for byte, _ in found] == list(range(96))
    assert inlet.lost == 0


def test_a_frame_leaves_byte_by_byte() -> None:
    outlet = Outlet(RATE, 64)
    outlet.send(b"abcd", outlet.write(4, 1.0)[0])

    assert outlet.collect(1.0015) == b"a"
    assert outlet.due_s == pytest.approx(1.004)
    assert outlet.collect(1.01) == b"bcd"
    assert outlet.due_s == math.inf


def test_a_write_waits_until_the_send_ring_has_room() -> None:
    outlet = Outlet(RATE, 64)

    assert outlet.write(64, 0.0) == (0.0, 0.0)
    start, done = outlet.write(40, 0.0)

    assert (start, done) == (pytest.approx(0.064), pytest.approx(0.040))


def test_a_restart_cuts_the_frame_on_the_line() -> None:
    outlet = Outlet(RATE, 64)
    outlet.send(b"abcdefgh", outlet.write(8, 0.0)[0])
    outlet.cut(0.003)

    assert outlet.collect(1.0) == b"abc"
