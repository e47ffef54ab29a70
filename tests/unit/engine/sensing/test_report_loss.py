"""How much is lost, and how long a board may be silent therefore."""

from __future__ import annotations

import math

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
