"""Finds out whether the robot is known to be stopped, from writings and echoes."""

from __future__ import annotations

from collections.abc import Collection, Sequence


class StopConfirmation:
    """Follows the arrays that are written and their echoes.

    Args:
        slots: Slots that are zero in the safe state.

    Attributes:
        confirmed: Whether the last array that drove a slot was followed by one that drives none and
            has been echoed. True while nothing has been driven.
    """

    def __init__(self, slots: Collection[int]) -> None:
        self._slots = tuple(slots)
        self._since: set[int] = set()
        self.confirmed = True

    def wrote(self, number: int, counts: Sequence[int]) -> None:
        """Take in an array that was written, with its number."""
        if any(counts[slot] for slot in self._slots):
            self.confirmed = False
            self._since.clear()
        else:
            self._since.add(number)

    def echoed(self, number: int, counts: Sequence[int]) -> None:
        """Take in an echo: the values that the device has applied."""
        if any(counts[slot] for slot in self._slots):
            self.confirmed = False
        elif number in self._since:
            self.confirmed = True
