"""An estimate as text for people."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pirate_sm.fitting.estimate import Estimate


def estimate_text(estimate: Estimate, unit: str = "") -> str:
    """Return a value with its 95 % interval, or why it is unknown."""
    if not estimate.known:
        bound = "" if isnan(estimate.low) else f"at least {estimate.low:.3f}{unit}, "
        return f"{bound}unknown: {estimate.reason}"
    if isnan(estimate.low):
        return f"{estimate.value:.3f}{unit}"
    return f"{estimate.value:.3f}{unit} [{estimate.low:.3f}, {estimate.high:.3f}]"
