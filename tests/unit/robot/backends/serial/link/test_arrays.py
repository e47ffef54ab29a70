"""When an array is written again, on a good line and on a bad one."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from itertools import pairwise

import pytest

from pirate_sm.core.events import FaultReport, SubmitResult
from pirate_sm.robot.backends.serial.link.arrays import SetpointLink
from pirate_sm.robot.backends.serial.link.health import NEVER, LineQuality, Refreshing
from pirate_sm.robot.backends.serial.link.link_plan import WireSlot

SPACING_S = 0.05
HURRY_S = 0.6 * SPACING_S
ROUND_TRIP_S = 0.08
TICK_S = 0.002


def pack(number: int, counts: Sequence[int], hold: int) -> bytes:
    return struct.pack("<Ih", number, *counts)


class Line:
    """The link with a device at its other end that echoes what is said to arrive."""

    def __init__(self, refreshing: Refreshing = NEVER) -> None:
        self.link = SetpointLink(
            [WireSlot("motor", 0.001, 1.0)],
            pack,
            echo_within_s=0.15,
            spacing_s=SPACING_S,
            refreshing=refreshing,
        )
        self.now_s = 0.0
        self.round_trip_s = ROUND_TRIP_S
        self.number = 0
        self.written: list[tuple[float, int, tuple[int, ...]]] = []
        self.echoes: list[tuple[float, int, tuple[int, ...]]] = []
        self.fates: dict[int, str] = {}

    def run(self, until_s: float, arriving: bool = True) -> None:
        """Time has passed."""
        while self.now_s < until_s:
            self.now_s += TICK_S
            while self.echoes and self.echoes[0][0] <= self.now_s:
                _, number, counts = self.echoes.pop(0)
                self.link.echoed(number, counts, self.now_s)
            self.link.expire(self.now_s)
            payload = self.link.next_payload(self.now_s)
            if payload:
                number, *counts = struct.unpack("<Ih", payload)
                self.written.append((self.now_s, number, tuple(counts)))
                if arriving:
                    self.echoes.append((self.now_s + self.round_trip_s, number, tuple(counts)))
            for result in self.link.take():
                self.fates[result.setpoint_id] = result.status

    def hear(self, share: float) -> None:
        """Much has come, of which this share was damaged."""
        for _ in range(100):
            self.link.quality.listened(100, round(100 * share))


@pytest.fixture
def line() -> Line:
    return Line()


def test_where_nothing_is_lost_nothing_is_written_twice(line: Line) -> None:
    for number in range(1, 20):
        line.link.submit(number, (number / 1000,), line.now_s)
        line.run(line.now_s + 0.2)

    assert len(line.written) == 19
    assert set(line.fates.values()) == {"accepted"}


def test_an_array_that_is_lost_once_is_awaited_once(line: Line) -> None:
    line.link.submit(1, (0.5,), line.now_s)
    line.run(0.05, arriving=False)
    line.run(0.5)

    first_s, second_s = (at_s for at_s, *_ in line.written[:2])
    assert second_s - first_s > ROUND_TRIP_S
    assert line.fates == {1: "accepted"}


@pytest.mark.parametrize(("damaged", "hurries"), [(0.1, False), (0.4, True)])
def test_bytes_that_come_damaged_tell_of_a_bad_line_before_anything_is_written(
    line: Line, damaged: float, hurries: bool
) -> None:
    line.hear(damaged)
    line.link.submit(1, (0.5,), line.now_s)
    line.run(0.079)

    times_s = [at_s for at_s, *_ in line.written]
    assert len(times_s) == (3 if hurries else 1)
    if hurries:
        gaps = [late - early for early, late in pairwise(times_s)]
        assert min(gaps) >= HURRY_S - TICK_S


def test_a_line_that_has_become_good_is_waited_for_again(line: Line) -> None:
    line.hear(0.5)
    line.hear(0.0)
    line.link.submit(1, (0.5,), line.now_s)
    line.run(0.079)

    assert len(line.written) == 1


def test_where_the_first_arrays_were_lost_the_next_ones_do_not_wait(line: Line) -> None:
    for number in (1, 2):
        line.link.submit(number, (number / 10,), line.now_s)
        line.run(line.now_s + 0.5, arriving=False)
        line.run(line.now_s + 0.5)
    line.written.clear()
    line.link.submit(3, (0.3,), line.now_s)
    line.run(line.now_s + 0.079)

    assert len(line.written) == 3


def test_the_last_copy_is_confirmed_too_for_it_may_be_the_damaged_one(line: Line) -> None:
    line.hear(0.5)
    line.link.submit(1, (0.5,), line.now_s)
    line.run(1.0)

    assert line.fates == {1: "accepted"}
    assert line.link.idle
    assert not line.echoes


def test_an_array_applied_damaged_is_written_again_at_once(line: Line) -> None:
    line.link.submit(1, (0.5,), line.now_s)
    line.run(0.01)
    _, number, _ = line.written[-1]
    line.echoes[:] = [(line.now_s + 0.04, number, (77,))]
    line.run(0.06)

    assert [counts for *_, counts in line.written] == [(500,), (500,)]


def test_nothing_older_is_written_after_something_newer(line: Line) -> None:
    line.hear(0.5)
    line.link.submit(1, (0.1,), line.now_s)
    line.run(0.04, arriving=False)
    line.link.submit(2, (0.2,), line.now_s)
    line.run(0.5)

    written = [counts[0] for *_, counts in line.written]
    assert written == sorted(written)
    assert line.fates == {1: "unknown", 2: "accepted"}


def test_a_newer_array_is_due_after_the_gap_once_the_one_under_way_is_accepted(line: Line) -> None:
    line.hear(0.5)
    line.link.submit(1, (0.1,), line.now_s)
    line.run(ROUND_TRIP_S + 2 * TICK_S)
    assert line.fates == {1: "accepted"}
    assert not line.link.idle, "its last copy is not confirmed"

    line.link.submit(2, (0.2,), line.now_s)

    assert line.link.due_s == pytest.approx(line.written[-1][0] + HURRY_S)


# --- a stream: arrays are submitted faster than echoes come ---------------------------------


def test_of_the_arrays_submitted_during_a_round_trip_only_the_newest_is_written(
    line: Line,
) -> None:
    line.link.submit(1, (0.1,), line.now_s)
    line.run(0.01)
    for number in (2, 3, 4):
        line.link.submit(number, (number / 10,), line.now_s)
        line.run(line.now_s + 0.01)

    assert line.fates == {2: "superseded", 3: "superseded"}
    line.run(ROUND_TRIP_S + 3 * TICK_S)
    assert line.fates == {1: "accepted", 2: "superseded", 3: "superseded"}
    assert [counts for *_, counts in line.written] == [(100,), (400,)]
    line.run(0.3)
    assert line.fates[4] == "accepted"


def test_a_newer_array_does_not_wait_longer_than_for_an_overdue_echo(line: Line) -> None:
    stream(line, until_s=1.0)
    line.written.clear()
    stream(line, until_s=2.0, arriving=False)

    gaps_s = [late - early for (early, *_), (late, *_) in pairwise(line.written)]
    assert max(gaps_s) < 0.15
    assert len(line.written) == len({counts for *_, counts in line.written}), "none is repeated"


def test_a_stream_without_echoes_tells_of_a_bad_line(line: Line) -> None:
    stream(line, until_s=1.0)
    assert not line.link.quality.bad
    stream(line, until_s=2.0, arriving=False)

    assert line.link.quality.bad


def test_echoes_that_come_after_a_newer_array_was_written_are_no_loss_and_are_learned_from(
    line: Line,
) -> None:
    stream(line, until_s=1.0)
    line.round_trip_s = 0.14
    stream(line, until_s=3.0)

    assert not line.link.quality.bad
    assert line.link.quality.lost_one_way < 0.01
    assert line.link.quality.patience_s > 0.14
    assert list(line.fates.values())[-20:].count("unknown") == 0


def stream(line: Line, until_s: float, arriving: bool = True) -> None:
    """A loop submits another array every 16 ms."""
    while line.now_s < until_s:
        line.number += 1
        line.link.submit(line.number, (line.number / 1000,), line.now_s)
        line.run(line.now_s + 0.016, arriving)


def test_while_a_last_copy_is_awaited_the_firmware_hears_as_much_as_from_refreshes() -> None:
    line = Line(Refreshing(every_s=0.2, stop_after_s=0.5))
    line.hear(0.75)
    line.link.submit(1, (0.5,), line.now_s)
    line.run(0.05)
    line.echoes[1:] = []
    line.run(0.1)
    assert line.fates == {1: "accepted"}
    assert not line.link.idle, "its last copy is not confirmed"

    line.run(0.6, arriving=False)

    gaps = [late - early for (early, *_), (late, *_) in pairwise(line.written)]
    assert max(gaps) < 0.05


def test_a_refresh_does_not_go_before_an_array_that_waits() -> None:
    line = Line(Refreshing(every_s=0.04, stop_after_s=0.5))
    line.link.submit(1, (0.1,), line.now_s)
    line.run(0.085)
    line.link.submit(2, (0.2,), line.now_s)
    line.run(0.5)

    counts = [each[0] for *_, each in line.written]
    assert counts == sorted(counts)
    assert line.fates == {1: "accepted", 2: "accepted"}


# --- margins ---------------------------------------------------------------------------------


def written_after_steady_echoes(line: Line, late_s: float) -> int:
    """How often an array is written whose echo takes so much longer than all before it."""
    for number in range(1, 60):  # until the spread of the round trips is nothing
        line.link.submit(number, (number / 1000,), line.now_s)
        line.run(line.now_s + 0.2)
    line.written.clear()
    line.link.submit(99, (0.99,), line.now_s)
    line.run(line.now_s + 0.01, arriving=False)
    [(sent_s, number, counts)] = line.written
    line.echoes.append((sent_s + ROUND_TRIP_S + late_s, number, counts))
    line.run(line.now_s + ROUND_TRIP_S + 0.05, arriving=False)
    return len(line.written)


@pytest.mark.parametrize(("late_s", "copies"), [(0.006, 1), (0.016, 2)])
def test_an_echo_may_be_late_by_ten_milliseconds_where_all_came_alike(
    line: Line, late_s: float, copies: int
) -> None:
    assert written_after_steady_echoes(line, late_s) == copies


def copies_at_once(line: Line) -> int:
    line.link.submit(1, (0.5,), line.now_s)
    line.run(line.now_s + 0.079)
    return len(line.written)


@pytest.mark.parametrize(("received", "copies"), [(700, 1), (1_000, 3)])
def test_noise_is_taken_over_two_thousand_bytes(line: Line, received: int, copies: int) -> None:
    line.link.quality.listened(received, round(0.6 * received))

    assert copies_at_once(line) == copies


@pytest.mark.parametrize(("damaged", "copies"), [(0.1, 1), (0.3, 3)])
def test_more_bytes_at_once_than_noise_is_taken_over_count_as_their_share(
    line: Line, damaged: float, copies: int
) -> None:
    line.link.quality.listened(10_000, round(10_000 * damaged))

    assert copies_at_once(line) == copies


def test_a_line_that_loses_no_more_than_a_quarter_is_not_bad() -> None:
    quality = LineQuality(0.15)
    quality.lose(0.5)  # the first of two counts half

    assert not quality.bad
    quality.lose(1.0)
    assert quality.bad


# --- what is in force, and what a device that was away gets again ----------------------------


def test_in_force_is_what_was_confirmed_last_and_before_that_what_was_written(line: Line) -> None:
    link = line.link
    assert (link.in_force, link.confirmed) == (None, None)
    link.submit(1, (0.1,), line.now_s)
    assert link.in_force is None, "it has not been written"
    line.run(0.05)
    assert (link.in_force, link.confirmed) == ((100,), None)
    line.run(0.3)
    assert (link.in_force, link.confirmed) == ((100,), (100,))

    link.submit(2, (0.2,), line.now_s)
    line.run(line.now_s + 0.05)

    assert (link.in_force, link.confirmed) == ((100,), None)
    line.run(line.now_s + 0.3)
    assert (link.in_force, link.confirmed) == ((200,), (200,))


def test_a_device_that_may_have_forgotten_the_last_array_gets_it_again(line: Line) -> None:
    line.link.reassert(line.now_s)
    line.run(0.1)
    assert not line.written, "there was none"
    line.link.submit(1, (0.1,), line.now_s)
    line.run(0.5)
    line.fates.clear()

    line.link.reassert(line.now_s)
    assert not line.link.idle
    line.run(line.now_s + 0.5)

    assert [counts for *_, counts in line.written] == [(100,), (100,)]
    assert line.link.confirmed == (100,)
    assert not line.fates, "it has its result already"


def test_the_echo_of_any_refresh_confirms_the_array() -> None:
    line = Line(Refreshing(every_s=0.2, stop_after_s=0.5))
    line.hear(0.75)
    line.link.submit(1, (0.1,), line.now_s)
    line.run(2.0)

    line.link.reassert(line.now_s)
    line.run(line.now_s + 2 * ROUND_TRIP_S)
    assert line.link.idle
    line.run(line.now_s + 10.0)

    assert line.link.confirmed == (100,)
    assert line.link.quality.lost_one_way < 0.6, "late echoes are no losses"


def test_without_refreshes_the_last_copy_is_awaited() -> None:
    line = Line(NEVER)
    line.link.submit(1, (0.0,), line.now_s)
    line.run(1.0)
    line.written.clear()

    line.link.reassert(line.now_s)
    line.run(line.now_s + 0.16, arriving=False)
    (_, first, counts), (_, last, _) = line.written
    line.link.echoed(first, counts, line.now_s)
    assert not line.link.idle, "the second copy may be what the device has now"
    line.link.echoed(last, (777,), line.now_s)
    line.run(line.now_s + 1.0)

    assert line.written[-1][2] == (0,), "written again"
    assert line.link.idle


def test_a_last_array_that_is_not_confirmed_again_is_a_fault(line: Line) -> None:
    line.link.submit(1, (0.1,), line.now_s)
    line.run(0.5)
    link, since_s = line.link, line.now_s
    link.reassert(since_s)

    found: list[SubmitResult | FaultReport] = []
    while not found and line.now_s < since_s + 10.0:
        line.now_s += TICK_S
        link.expire(line.now_s)
        link.next_payload(line.now_s)
        found = link.take()

    assert [each.code for each in found if isinstance(each, FaultReport)] == ["link.no_echo"]
    assert line.now_s - since_s == pytest.approx(8 * 0.15 * 5, abs=0.15)
    assert link.idle


def test_an_array_without_any_echo_is_unknown_after_its_time(line: Line) -> None:
    line.link.submit(1, (0.1,), line.now_s)
    line.run(8 * 0.15 - 0.05, arriving=False)
    assert not line.fates

    line.run(8 * 0.15 + 0.2, arriving=False)

    assert line.fates == {1: "unknown"}
    assert line.link.idle


@pytest.mark.parametrize("written", [True, False])
def test_where_nothing_can_be_written_for_long_the_newest_array_is_kept_for_later(
    line: Line, written: bool
) -> None:
    link = line.link
    link.submit(1, (0.1,), 0.0)
    if written:
        link.next_payload(0.0)
        link.submit(2, (0.2,), 0.1)

    link.expire(1.15, able=False)
    assert not link.idle
    link.expire(1.35, able=False)

    results = {each.setpoint_id: each for each in link.take() if isinstance(each, SubmitResult)}
    assert {each.status for each in results.values()} == {"unknown"}
    assert results[2 if written else 1].reason == "the link is down"
    assert link.idle
    assert link.in_force == ((200,) if written else (100,)), "to be repeated"
