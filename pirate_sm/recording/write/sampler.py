"""Looks at a run at intervals, for what a recording holds beside the engine's topics.

Nothing depends on it: an error here ends the samples, not the recording or the run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import Generic, TypeVar

from pirate_sm.geometry.space import Place
from pirate_sm.recording.viewers.viewer_messages import ViewerSnapshot

EVERY_S = 0.1
"""Interval of the samples, mission time, s."""

Taken = TypeVar("Taken")


class Sampler(Generic[Taken]):
    """Takes samples of the run.

    Args:
        keep: Returns what is kept of the run's state at a mission time.

    Attributes:
        due_s: Mission time of the next sample.
        failure: Why there are no more samples; empty while there are.
    """

    def __init__(self, keep: Callable[[float, ViewerSnapshot], Taken]) -> None:
        self.due_s = 0.0
        self.failure = ""
        self._keep = keep
        self._look: Callable[[], ViewerSnapshot | None] = lambda: None

    def follow(self, look: Callable[[], ViewerSnapshot | None]) -> None:
        """Set the function that returns the state of the run; None before it has begun."""
        self._look = look

    def look(self, now_s: float, wheels: Sequence[Place] | None = None) -> Taken | None:
        """Return a sample; None before the run has begun.

        Args:
            now_s: Mission time, s.
            wheels: Where the wheels were then, if they have moved since; None: where they are now.
        """
        self.due_s = now_s + EVERY_S
        try:
            snapshot = self._look()
            if snapshot is not None and wheels is not None:
                snapshot = snapshot._replace(wheels=tuple(wheels))
            return None if snapshot is None else self._keep(now_s, snapshot)
        except Exception as error:
            self.fail(error)
            return None

    def fail(self, error: Exception) -> None:
        """End the samples because of this error."""
        self.failure = f"{type(error).__name__}: {error}"
        self.due_s = inf
