"""How good the line is, and how often the array in force is repeated on it."""

from __future__ import annotations

from math import inf

import pytest

from pirate_sm.robot.backends.serial.link.health import NEVER, LineQuality, Refreshing

LONGEST_S = 0.4


@pytest.fixture
def quality() -> LineQuality:
    return LineQuality(LONGEST_S)


def test_before_the_first_echo_the_longest_time_is_waited(quality: LineQuality) -> None:
    assert quality.patience_s == LONGEST_S


def test_echoes_that_come_alike_are_awaited_little_longer(quality: LineQuality) -> None:
    for _ in range(200):
        quality.learn(0.05)

    assert quality.patience_s == pytest.approx(0.06, abs=1e-3)
    assert list(quality.round_trips) == [0.05] * 200


def test_echoes_that_vary_are_awaited_for_four_times_their_spread(quality: LineQuality) -> None:
    for number in range(400):
        quality.learn(0.05 if number % 2 else 0.07)

    assert quality.patience_s == pytest.approx(0.06 + 4 * 0.01 + 0.01, abs=3e-3)


def test_only_the_last_thousand_echoes_are_kept(quality: LineQuality) -> None:
    for number in range(1001):
        quality.learn(number / 1e6)

    assert len(quality.round_trips) == 1000


def test_losses_count_as_their_share_of_the_first_writings_and_then_of_the_last_ones(
    quality: LineQuality,
) -> None:
    quality.lose(1.0)
    assert 1 - (1 - quality.lost_one_way) ** 2 == pytest.approx(1 / 2)
    quality.lose(0.0)
    assert 1 - (1 - quality.lost_one_way) ** 2 == pytest.approx(1 / 3)
    for _ in range(100):
        quality.lose(0.0)
    assert not quality.bad
    for _ in range(5):
        quality.lose(1.0)
    assert 1 - (1 - quality.lost_one_way) ** 2 == pytest.approx(1 - (15 / 16) ** 5, abs=0.01)


def test_bytes_are_counted_and_those_of_no_frame_are_noise(quality: LineQuality) -> None:
    quality.listened(0, 5)
    assert (quality.received, quality.lost_one_way) == (0, 0.0)

    quality.listened(1000, 800)
    quality.listened(500, 0)

    assert quality.received == 1500
    assert 1 - (1 - quality.lost_one_way) ** 2 == pytest.approx(0.4 * 0.75)


def test_on_a_line_that_is_nothing_but_noise_something_is_still_taken_to_come(
    quality: LineQuality,
) -> None:
    quality.listened(2000, 9000)

    assert quality.lost_one_way == pytest.approx(0.9)


def test_the_array_in_force_is_repeated_so_often_that_the_switch_hardly_ever_trips() -> None:
    refreshing = Refreshing(every_s=0.2, stop_after_s=0.6)

    assert NEVER.interval_s(0.5, 0.03) == inf
    assert Refreshing(every_s=0.2).interval_s(0.5, 0.03) == 0.2
    assert refreshing.interval_s(0.0, 0.03) == 0.2
    assert refreshing.interval_s(0.1, 0.03) == pytest.approx(0.6 / 4), "four lost of 1e-4"
    assert refreshing.interval_s(0.001, 0.03) == 0.2, "no less often than on a good line"
    assert refreshing.interval_s(0.9, 0.03) == 0.03, "no more often than the line allows"
    assert refreshing.interval_s(1.0, 0.0) == pytest.approx(0.6 / 917)
