"""Derive how long a board may be silent from the share of reports that are lost."""

from __future__ import annotations

from math import inf, log

from pirate_sm.core._engine.sensing.board_spec import LinkSpec
from pirate_sm.core._engine.signals.evaluator import GAIN

_FALSE_ALARM = 1e-6
"""Probability per report that a board is taken for silent although it reports."""

_UNTRIED = 0.5
"""Loss assumed before the first report, of a line that changes 1 % of all bytes and loses 20 %."""

LONGEST = 5.0
"""Upper limit as a multiple of ``silent_after``: a silent board is found within it at any loss."""


def silent_limit_s(link: LinkSpec, loss: float, reports: float = inf) -> float:
    """Return how long a single board may be silent.

    That is ``silent_after``, or on a lossy line the number of periods that makes a false alarm
    rare, at most :data:`LONGEST` times ``silent_after``.

    Args:
        link: Timing of the link.
        loss: The share of lost reports so far, a running mean that begins at 0.
        reports: How many reports all boards have been due to send since then. While they are few,
            the share says little, and the line may lose half.
    """
    loss += _UNTRIED * (1 - GAIN) ** reports
    if loss <= 0:
        return link.silent_after_s
    patience_s = link.period_s * log(_FALSE_ALARM) / log(loss) if loss < 1 else inf
    return min(max(link.silent_after_s, patience_s), LONGEST * link.silent_after_s)
