"""Looks at a run at intervals, for what a recording holds beside the engine's topics.

Nothing depends on it: an error here ends the samples, not the recording or the run.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import Generic, TypeAlias, TypeVar

from pirate_sm.model.trail import Stood

EVERY_S = 0.1
"""Interval of the samples, mission time, s."""

Taken = TypeVar("Taken")

Look: TypeAlias = Callable[[float, Stood | None], Taken | None]
"""Returns a sample, as :meth:`Sampler.look` does."""


class Sampler(Generic[Taken]):
    """Takes samples of the run.

    Attributes:
        due_s: Mission time of the next sample.
        follows_trails: Whether it needs no more than to know where the robot was.
        failure: Why there are no more samples; empty while there are.
    """

    def __init__(self) -> None:
        self.due_s = 0.0
        self.failure = ""
        self.follows_trails = False
        self._look: Look[Taken] = lambda now_s, stood: None

    def follow(self, look: Look[Taken], *, trails: bool = False) -> None:
        """Set the function that takes samples of the run.

        Args:
            look: The function.
            trails: Whether it needs no more than to know where the robot was.
        """
        self._look, self.follows_trails = look, trails

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

    def fail(self, error: Exception) -> None:
        """End the samples because of this error."""
        self.failure = f"{type(error).__name__}: {error}"
        self.due_s = inf
