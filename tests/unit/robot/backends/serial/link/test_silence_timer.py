"""A silence is measured by the time in which we were awake ourselves."""

from __future__ import annotations

import pytest

from pirate_sm.robot.backends.serial.link.conversation import SilenceTimer

NAP_S = 0.05


def looked(patience: SilenceTimer, since_s: float, until_s: float) -> float:
    """What a look at the end says after regular looks."""
    waited_s, steps = 0.0, round((until_s - since_s) / NAP_S)
    for step in range(1, steps + 1):
        waited_s = patience.look(since_s + step * NAP_S)
    return waited_s


@pytest.fixture
def patience() -> SilenceTimer:
    patience = SilenceTimer(NAP_S)
    patience.hear(0.0)
    return patience


def test_a_silence_that_was_watched_counts(patience: SilenceTimer) -> None:
    assert looked(patience, 0.0, 0.3) == pytest.approx(0.3)


def test_whoever_is_heard_begins_again(patience: SilenceTimer) -> None:
    looked(patience, 0.0, 0.25)
    patience.hear(0.25)

    assert looked(patience, 0.25, 0.3) == pytest.approx(0.05)


def test_after_a_standstill_of_our_own_the_other_side_has_its_whole_time_again(
    patience: SilenceTimer,
) -> None:
    looked(patience, 0.0, 0.25)

    assert patience.look(5.0) == 0.0
    assert looked(patience, 5.0, 5.25) == pytest.approx(0.25)


def test_further_standstills_without_a_word_in_between_do_not_put_it_off_for_ever(
    patience: SilenceTimer,
) -> None:
    waited_s = [patience.look(now) for now in range(1, 9)]

    assert waited_s[0] == 0.0
    assert waited_s[-1] >= 0.3


def test_it_wants_to_look_in_time_for_the_limit_and_often_enough_to_notice_a_standstill(
    patience: SilenceTimer,
) -> None:
    assert patience.due_s(0.3) == pytest.approx(NAP_S)
    looked(patience, 0.0, 0.25)
    patience.look(0.27)
    assert patience.due_s(0.3) == pytest.approx(0.3)
