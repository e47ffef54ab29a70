"""Random loss of messages."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np


class Loss:
    """Decides at random which messages arrive.

    Args:
        share: Share of lost messages.
        never_two: Whether one of two consecutive messages of a kind always arrives.
        rng: Random numbers.
    """

    def __init__(self, share: float, never_two: bool, rng: np.random.Generator) -> None:
        # After a loss one message always arrives, so more of the others must be lost.
        self._share = share / (1.0 - share) if never_two else share
        self._never_two = never_two
        self._rng = rng
        self._just_lost: set[Hashable] = set()

    def arrives(self, kind: Hashable) -> bool:
        """Return whether the next message of this kind arrives."""
        if self._share == 0.0:
            return True
        if kind in self._just_lost:
            self._just_lost.discard(kind)
            return True
        if self._rng.random() >= self._share:
            return True
        if self._never_two:
            self._just_lost.add(kind)
        return False
