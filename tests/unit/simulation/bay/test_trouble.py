"""Each switch does what it says."""

from __future__ import annotations

import itertools

import pytest

from .conftest import ECHO, SETPOINTS, STATE, Host, MakeBay, array, read_array, read_state

WHEEL = 5


def connected(make: MakeBay, seed: int = 1, **switches: object) -> Host:
    host = make(seed, boot_s=1.0, **switches)
    host.open()
    while not any(each.topic == STATE for each in host.heard) and host.now_s < 10.0:
        host.listen(0.1)
        host.send(0)
    host.listen(0.1)
    return host


def drive(host: Host, number: int = 1, duty: int = 1000) -> None:
    host.send(SETPOINTS, array(number, *(0,) * WHEEL, duty))


def echoes(host: Host) -> list[int]:
    return [read_array(each.payload)[0] for each in host.heard if each.topic == ECHO]


def send_many(host: Host, count: int) -> None:
    for number in range(count):
        drive(host, number, number)
        host.listen(0.1)


@pytest.mark.thorough
def test_lost_on_the_way_in(make: MakeBay) -> None:
    host = connected(make, loss_in=0.2)
    send_many(host, 500)
    received = [each.setpoint_id for each in host.events("received")]

    assert len(received) / 500 == pytest.approx(0.8, abs=0.05)
    assert echoes(host) == received[: len(echoes(host))]


def test_lost_on_the_way_out(make: MakeBay) -> None:
    host = connected(make, loss_out=0.2)
    before = len([each for each in host.heard if each.topic == STATE])
    began = host.now_s
    send_many(host, 500)
    states = len([each for each in host.heard if each.topic == STATE]) - before

    assert len(host.events("applied")) == 500
    assert len(echoes(host)) / 500 == pytest.approx(0.8, abs=0.05)
    assert states / (62.5 * (host.now_s - began)) == pytest.approx(0.8, abs=0.02)


def test_nothing_passes_a_line_that_is_cut(make: MakeBay) -> None:
    host = connected(make, cut_at_s=10.0)
    drive(host, 1, 1000)
    host.listen(10.1 - host.now_s)
    heard = len(host.heard)
    drive(host, 2, -1000)
    host.listen(5.0)

    assert [each.setpoint_id for each in host.events("applied")][-1] == 1
    assert len(host.heard) - heard <= 1  # what had left the controller before


def test_never_two_in_a_row(make: MakeBay) -> None:
    host = connected(make, loss_in=0.3, loss_out=0.3, never_two=True)
    send_many(host, 300)
    received = [each.setpoint_id for each in host.events("received")]
    gaps = [b - a for a, b in itertools.pairwise(received)]

    assert set(gaps) == {1, 2}


def test_changed_bytes(make: MakeBay) -> None:
    host = connected(make, corruption=0.01)
    send_many(host, 400)
    received = host.events("received")

    # 0.99 ** 48 of the frames are whole.
    assert len(received) / 400 == pytest.approx(0.62, abs=0.08)


def test_later_frames(make: MakeBay) -> None:
    def trip(**switches: float) -> float:
        host = connected(make, **switches)
        sent = host.now_s
        drive(host)
        host.listen(0.5)
        return next(each.at_s for each in host.heard if each.topic == ECHO) - sent

    plain = trip()
    assert trip(delay_s=0.1) == pytest.approx(plain + 0.2, abs=0.02)
    assert plain - 0.02 < trip(jitter_s=0.05) < plain + 0.12


def test_a_restart_at_a_time(make: MakeBay) -> None:
    host = connected(make, reset_at_s=(5.0,))
    drive(host)
    host.listen(4.9 - host.now_s)
    assert max(host.bay.duties) == 1.0
    host.listen(3.0)

    assert [each.at_s for each in host.events("reset")] == [0.0, 5.0]
    assert [each for each in host.heard if each.at_s > 5.02] == []
    assert set(host.bay.duties) == {0.0}
    host.send(0)
    assert host.listen(0.2) != []


def test_restarts_at_random(make: MakeBay) -> None:
    host = make(reset_every_s=5.0)
    host.listen(100.0)

    assert len(host.events("reset")) == pytest.approx(20, abs=10)


def test_standing_still(make: MakeBay) -> None:
    host = connected(make, hang_at_s=5.0, hang_for_s=3.0)
    drive(host, 1)
    host.listen(5.1 - host.now_s)
    drive(host, 2, 0)
    assert [each for each in host.listen(2.8) if each.at_s > 5.12] == []
    assert max(host.bay.duties) == 1.0
    host.listen(1.0)

    assert set(host.bay.duties) == {0.0}
    assert host.listen(0.5) != []


def test_standing_still_for_good(make: MakeBay) -> None:
    host = connected(make, hang_at_s=3.0)
    host.listen(3.1 - host.now_s)
    host.send(0)

    assert host.listen(20.0) == []


def test_how_long_booting_takes(make: MakeBay) -> None:
    host = make(boot_s=7.0)
    host.open()
    host.listen(8.0)

    assert [each.at_s for each in host.events("booted")] == [7.0]


def test_boards_repeat_their_values(make: MakeBay) -> None:
    def changes(**switches: float) -> float:
        host = connected(make, **switches)
        host.listen(10.0)
        states = [read_state(each.payload) for each in host.heard if each.topic == STATE]
        mine = [values for board, values in states if board == 24]
        return sum(a != b for a, b in itertools.pairwise(mine)) / len(mine)

    assert changes() > 0.95
    assert changes(stale_every_s=0.5, stale_for_s=0.5) < 0.8


def test_a_wrong_md5(make: MakeBay) -> None:
    host = connected(make, wrong_md5=("state",))
    right = connected(make)
    introductions = [
        [each.payload for each in it.heard if each.topic in (0, 1)] for it in (host, right)
    ]
    same = [a == b for a, b in zip(*introductions, strict=False)]

    assert same[:3] == [False, True, True]
    assert len(introductions[0][0]) == len(introductions[1][0])


def test_obeying_without_echo(make: MakeBay) -> None:
    host = connected(make, unconfigured_at_s=(4.0,))
    host.listen(4.1 - host.now_s)
    drive(host)

    assert host.listen(1.0) == []
    assert max(host.bay.duties) == 1.0
    host.send(0)
    host.listen(0.2)
    drive(host, 2, 500)
    host.listen(0.2)
    assert echoes(host) == [2]


def test_a_motor_that_nobody_asked(make: MakeBay) -> None:
    host = connected(make, spontaneous_at_s=(4.0,))
    host.listen(3.9 - host.now_s)
    assert set(host.bay.duties) == {0.0}
    host.listen(0.2)

    assert sum(duty != 0.0 for duty in host.bay.duties) == 1
    drive(host, 1, 0)
    host.listen(0.1)
    assert set(host.bay.duties) == {0.0}


def test_motors_not_started(make: MakeBay) -> None:
    host = connected(make, motors_started=False)
    drive(host)
    host.listen(0.2)

    assert echoes(host) == [1]
    assert set(host.bay.duties) == {0.0}


def test_sensors_not_started(make: MakeBay) -> None:
    host = make(sensors_started=False)
    host.connect()
    drive(host)
    heard = host.listen(3.0)

    assert echoes(host) == [1]
    assert {each.topic for each in heard} == {ECHO, 10}


def test_a_defect_of_the_sensors(make: MakeBay) -> None:
    host = connected(make, defects=("gamma_2_sticks_at_zero",))
    host.send(SETPOINTS, array(1, *(0,) * 6, 500))
    host.listen(8.0 - host.now_s)
    states = [(e.at_s, *read_state(e.payload)) for e in host.heard if e.topic == STATE]
    angles = [values[0] for at, board, values in states if board == 23 and at > 5.1]

    assert set(angles) == {0.0}
    assert abs(host.bay.truth.bends_rad[2]) > 0.3


def test_a_bay_that_falls_silent_and_moves(make: MakeBay) -> None:
    host = connected(make, defects=("bay_silent",))
    host.listen(12.1 - host.now_s)
    drive(host)
    heard = host.listen(5.0)

    assert {each.topic for each in heard} <= {10}
    assert any(duty != 0.0 for duty in host.bay.duties)


def test_lost_messages_as_the_profile_has_them(make: MakeBay) -> None:
    host = connected(make, defects=("messages_lost",))
    send_many(host, 200)

    assert len(host.events("received")) == 200
    assert len(host.events("applied")) == pytest.approx(160, abs=20)
    assert len(echoes(host)) == pytest.approx(128, abs=25)


def test_boards_that_start_again_take_the_bay_with_them(make: MakeBay) -> None:
    host = connected(make, defects=("firmware_reset",))
    host.listen(17.0 - host.now_s)

    assert [round(each.at_s) for each in host.events("reset")] == [0, 15]
    assert host.listen(1.0) == []


def test_dead_wheels_stand_still_behind_the_bay(make: MakeBay) -> None:
    host = connected(make, defects=("wheels_3_4_dead",))
    host.send(SETPOINTS, array(1, *(0,) * 9, 1000))
    host.listen(1.0)
    states = [read_state(each.payload) for each in host.heard if each.topic == STATE]

    assert {values[6] for board, values in states if board == 24} == {0.0}
