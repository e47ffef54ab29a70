from __future__ import annotations

import random
from math import isnan, nan

import pytest

from pirate_sm.robot.detectors.word_timing import Tracker


def follow(places: list[float], *, driven: bool, every_s: float = 0.05) -> Tracker:
    tracker = Tracker()
    for step, place in enumerate(places):
        tracker.see(every_s * step, (place,), driven=driven)
    return tracker


def drive(count: int) -> list[float]:
    """0.1 m/s, seen every 50 ms."""
    return [0.005 * step for step in range(count)]


def test_a_driven_wheel_is_read_off_the_line_through_its_places() -> None:
    assert follow(drive(20), driven=True).place(0) == pytest.approx(0.095)


def test_places_far_off_the_line_count_for_nothing() -> None:
    places = drive(20)
    places[14] -= 0.5
    places[19] += 0.5  # also the last one
    assert follow(places, driven=True).place(0) == pytest.approx(0.095, abs=0.006)


@pytest.mark.parametrize("seed", range(12))
def test_white_noise_is_filtered(seed: int) -> None:
    chance = random.Random(seed)
    noisy = [place + chance.gauss(0.0, 0.005) for place in drive(60)]
    tracker, off = Tracker(), []
    for step, place in enumerate(noisy):
        tracker.see(0.05 * step, (place,), driven=True)
        off.append(tracker.place(0) - 0.005 * step)
    assert max(map(abs, off[8:])) < 0.012
    assert max(map(abs, off)) < max(abs(a - b) for a, b in zip(noisy, drive(60), strict=True))


def test_a_late_position_is_read_ahead_by_how_most_wheels_move() -> None:
    tracker = Tracker()
    for step in range(9):
        at_s = 0.05 * step
        # The last wheel cuts a corner: along the pipe it goes three times as fast.
        places = (1.0 + 0.1 * at_s, 0.9 + 0.1 * at_s, 0.8 + 0.3 * at_s)
        tracker.see(at_s + 0.2, places, driven=True, seen_s=at_s)

    assert tracker.place(0) == pytest.approx(1.0 + 0.1 * 0.6)
    assert tracker.place(2) == pytest.approx(0.8 + 0.3 * 0.4 + 0.1 * 0.2)
    assert tracker.speed() == pytest.approx(0.1)


def test_a_standing_robot_is_never_extrapolated() -> None:
    # As if a part settled slowly: on a line it would seem to be farther than it was ever seen.
    places = drive(9)
    assert follow(places, driven=False).place(0) == pytest.approx(places[4])
    chance = random.Random(1)
    tracker = Tracker()
    seen: list[float] = []
    for step in range(100):
        seen.append(chance.gauss(0.5, 0.005))
        tracker.see(0.05 * step, (seen[-1],), driven=False)
        assert min(seen) <= tracker.place(0) <= max(seen)


def test_what_was_seen_before_the_robot_stopped_does_not_move_it_afterwards() -> None:
    tracker = follow(drive(20), driven=True)
    for step in range(20):
        tracker.see(1.0 + 0.05 * step, (0.095,), driven=False)
        assert tracker.place(0) == pytest.approx(0.095)


def test_an_unknown_place_is_unknown_and_does_not_spoil_the_next() -> None:
    places = [*drive(10), nan]
    tracker = follow(places, driven=True)
    assert isnan(tracker.place(0))
    tracker.see(0.55, (0.055,), driven=True)
    assert tracker.place(0) == pytest.approx(0.055)


@pytest.mark.parametrize("driven", [True, False])
@pytest.mark.parametrize(("later_s", "known"), [(0.55, True), (0.65, False)])
def test_belief_in_a_place_ends_when_it_has_not_been_seen_for_too_long(
    driven: bool, later_s: float, known: bool
) -> None:
    tracker = follow(drive(20), driven=driven)
    tracker.see(0.95 + later_s, None, driven=driven)

    assert isnan(tracker.place(0)) != known
    assert isnan(tracker.speed()) != known


def test_belief_in_a_place_ends_where_wheels_begin_or_cease_to_be_driven() -> None:
    tracker = follow([0.5] * 20, driven=False)
    tracker.see(1.0, None, driven=True)
    assert isnan(tracker.place(0))

    tracker.see(1.1, (0.5,), driven=True, seen_s=0.99)
    assert isnan(tracker.place(0))
    assert list(tracker.seen) == []

    tracker.see(1.2, (0.51,), driven=True, seen_s=1.0)
    assert tracker.place(0) == pytest.approx(0.51)
    tracker.see(1.3, (0.53,), driven=False, seen_s=1.25)
    assert isnan(tracker.place(0))


def test_a_speed_takes_two_positions() -> None:
    assert isnan(follow([0.5], driven=True).speed())
    assert follow([0.5, 0.505], driven=True).speed() == pytest.approx(0.1)


def test_two_positions_of_one_moment_show_no_speed() -> None:
    tracker = Tracker()
    for at_s, place_m in ((0.0, 0.5), (0.0, 0.6), (0.1, 0.51), (0.1, 0.61)):
        tracker.see(at_s, (place_m,), driven=True)

    assert tracker.speed() == pytest.approx(0.1)


def test_nothing_is_driven_before_anything_was_seen() -> None:
    assert not Tracker().driven
    assert isnan(Tracker().place(0))


def test_a_robot_that_is_not_driven_stays_where_it_was_seen() -> None:
    tracker = Tracker()
    for turn in range(3):
        tracker.see(turn / 10, [turn / 100], driven=False)
    tracker.see(0.5, None, driven=False)

    assert tracker.place(0) == 0.01


def test_a_wheel_that_was_seen_once_says_nothing_about_the_speed() -> None:
    tracker = Tracker()
    for turn in range(5):
        tracker.see(turn / 10, [turn / 10, nan if turn < 4 else 3.0], driven=True)

    assert tracker.speed() == pytest.approx(1.0)
    assert tracker.place(1) == 3.0


def test_two_places_at_one_time_have_no_speed() -> None:
    tracker = Tracker()
    tracker.see(0.0, [0.0], driven=True)
    tracker.see(0.0, [2.0], driven=True)

    assert tracker.place(0) == 1.0
    assert tracker.speed() == 0.0
