"""Estimate how many reports are lost, and how long a board may therefore be silent."""

from __future__ import annotations

from math import log

from pirate_sm.engine.sensing.board_spec import LinkSpec

_GAIN = 1 / 64
"""Weight of one report: six boards with a period of 0.1 s make 64 in about a second."""

_MOST_MISSED = 8
"""A longer gap is the board's silence, not the line's loss, and counts as this many reports."""

_FALSE_ALARM = 1e-6
"""Chance that a board which reports all the time is taken to be silent, per report."""

LONGEST = 5.0
"""Times ``silent_after``: a silent board is found within that, however much is lost."""


def loss_after(loss: float, elapsed_s: float, period_s: float) -> float:
    """Return the share of reports that is lost, after one more has come.

    Args:
        loss: The share before, a running mean over the reports of all boards.
        elapsed_s: Since the same board's last report.
        period_s: Between two reports of one board where nothing is lost.
    """
    if elapsed_s > 1.5 * period_s:
        missed = round(min(elapsed_s / period_s - 1, _MOST_MISSED))
        loss = 1 - (1 - loss) * (1 - _GAIN) ** missed
    return loss * (1 - _GAIN)


def silent_limit_s(link: LinkSpec, loss: float) -> float:
    """Return how long a single board may be silent.

    That is ``silent_after``, or on a bad line as many periods as make a false alarm rare, but
    never more than :data:`LONGEST` times ``silent_after``.
    """
    if loss <= 0:
        return link.silent_after_s
    patience_s = link.period_s * log(_FALSE_ALARM) / log(loss)
    return min(max(link.silent_after_s, patience_s), LONGEST * link.silent_after_s)
