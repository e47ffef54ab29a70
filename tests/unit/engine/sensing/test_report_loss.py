"""How much is lost, and how long a board may be silent therefore."""

from __future__ import annotations

import math
from random import Random

import pytest

from pirate_sm.engine.sensing.board_spec import LinkSpec
from pirate_sm.engine.sensing.report_loss import LONGEST, loss_after, silent_limit_s

PERIOD_S = 0.1
LINK = LinkSpec(PERIOD_S, 0.5, 1.0, 0.2, 5)


def loss_over(gaps: list[int], reports: int = 2000) -> float:
    """The share after reports with these gaps, in periods, again and again."""
    loss, total = 0.0, 0.0
    for at in range(reports):
        loss = loss_after(loss, gaps[at % len(gaps)] * PERIOD_S, PERIOD_S)
        total += loss if at >= reports // 2 else 0.0
    return total / (reports - reports // 2)


@pytest.mark.parametrize(
    ("gaps", "lost"), [([1], 0.0), ([2], 0.5), ([4], 0.75), ([1, 1, 1, 2], 0.2), ([3, 1], 0.5)]
)
def test_the_share_is_that_of_the_reports_that_did_not_come(gaps: list[int], lost: float) -> None:
    assert loss_over(gaps) == pytest.approx(lost, abs=0.02)


@pytest.mark.parametrize("elapsed", [0.0, 0.3, 0.9, 1.4])
def test_reports_that_have_waited_together_are_no_loss(elapsed: float) -> None:
    assert loss_after(0.0, elapsed * PERIOD_S, PERIOD_S) == 0.0


def test_one_board_that_was_away_for_long_does_not_make_a_bad_line() -> None:
    assert loss_after(0.0, 600.0, PERIOD_S) < 0.15
    assert loss_after(0.0, math.inf, PERIOD_S) < 0.15, "nor does one that was never heard"


@pytest.mark.parametrize(
    ("loss", "limit_s"),
    [(0.0, 1.0), (0.2, 1.0), (0.25, 1.0), (0.5, 2.0), (0.7, 3.9), (0.75, 4.8), (0.9, 5.0)],
)
def test_a_board_may_be_silent_for_longer_where_more_is_lost(loss: float, limit_s: float) -> None:
    assert silent_limit_s(LINK, loss) == pytest.approx(limit_s, abs=0.05)


def test_a_silent_board_is_found_however_much_is_lost() -> None:
    assert silent_limit_s(LINK, 0.999) == LONGEST * LINK.silent_after_s


@pytest.mark.parametrize(
    ("loss", "reports", "limit_s"),
    [(0.0, 0, 2.0), (0.0, 20, 1.35), (0.0, 60, 1.0), (0.5, 0, 5.0), (0.5, 300, 2.0), (0.6, 5, 5.0)],
)
def test_a_board_may_be_silent_for_longer_while_few_reports_were_due(
    loss: float, reports: float, limit_s: float
) -> None:
    assert silent_limit_s(LINK, loss, reports) == pytest.approx(limit_s, abs=0.05)


def test_on_a_line_that_loses_half_no_board_that_reports_is_silent_at_the_beginning() -> None:
    random, boards, alarms = Random(1), 6, 0
    for _ in range(500):
        loss, heard_s = 0.0, [0.0] * boards
        for due in range(1, 30 * boards):
            now, board = due * PERIOD_S / boards, due % boards
            if random.random() < 0.5:
                loss = loss_after(loss, max(now - heard_s[board], PERIOD_S), PERIOD_S)
                heard_s[board] = now
            alarms += min(heard_s) <= now - silent_limit_s(LINK, loss, due)

    assert alarms == 0
