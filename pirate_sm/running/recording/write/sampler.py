"""Looks at a run at intervals, for what a recording holds beside the engine's topics.

Nothing depends on it: an error here ends the samples, not the recording or the run.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from math import inf
from typing import Generic, TypeAlias, TypeVar

from pirate_sm.core.simulation import Stood, Trail

EVERY_S = 0.1
"""Interval of the samples, mission time, s."""

Taken = TypeVar("Taken")

Look: TypeAlias = Callable[[float, Stood | None], Taken | None]
"""Returns a sample, as :meth:`Sampler.look` does."""

LookBack: TypeAlias = Callable[[Sequence[float], Trail], Taken]
"""Returns samples of these times, s, from where the robot was."""


class Sampler(Generic[Taken]):
    """Takes samples of the run.

    Attributes:
        due_s: Mission time of the next sample.
        failure: Why there are no more samples; empty while there are.
    """

    def __init__(self) -> None:
        self.due_s = 0.0
        self.failure = ""
        self._look: Look[Taken] = lambda now_s, stood: None
        self._look_back: LookBack[Taken] | None = None

    @property
    def follows_trails(self) -> bool:
        """Return whether it needs no more than to know where the robot was."""
        return self._look_back is not None

    def follow(self, look: Look[Taken], look_back: LookBack[Taken] | None = None) -> None:
        """Set the functions that take samples of the run.

        Args:
            look: Takes one sample.
            look_back: Takes many at once; None if it needs more than where the robot was.
        """
        self._look, self._look_back = look, look_back

    def look(self, now_s: float, stood: Stood | None = None) -> Taken | None:
        """Return a sample; None before the run has begun.

        Args:
            now_s: Mission time, s.
            stood: Where the robot was then, if it has moved since; None: where it is now.
        """
        self.due_s = now_s + EVERY_S
        try:
            return self._look(now_s, stood)
        except Exception as error:
            self.fail(error)
            return None

    def look_back(self, times_s: Sequence[float], trail: Trail) -> Taken | None:
        """Return the samples that are due at steps of these times; None without any.

        Args:
            times_s: Mission times, s, never decreasing.
            trail: Where the robot was then.
        """
        if self._look_back is None:
            return None
        due = list[float]()
        while times_s and times_s[-1] >= self.due_s:
            due.append(times_s[bisect_left(times_s, self.due_s)])
            self.due_s = due[-1] + EVERY_S
        try:
            return self._look_back(due, trail) if due else None
        except Exception as error:
            self.fail(error)
            return None

    def fail(self, error: Exception) -> None:
        """End the samples because of this error."""
        self.failure = f"{type(error).__name__}: {error}"
        self.due_s = inf
