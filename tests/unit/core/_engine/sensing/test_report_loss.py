"""How long a board may be silent where reports are lost."""

from __future__ import annotations

from random import Random

import pytest

from pirate_sm.core._engine.safety import LONGEST, silent_limit_s
from pirate_sm.core._engine.sensing.board_spec import LinkSpec
from pirate_sm.core._engine.sensing.evaluator import loss_after

PERIOD_S = 0.1
LINK = LinkSpec(PERIOD_S, 0.5, 1.0, 0.2, 5)


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
