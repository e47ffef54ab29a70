"""Bring the robot to its safe state when a step of a pump raises."""

from __future__ import annotations

from types import TracebackType

from pirate_sm.errors import BackendError
from pirate_sm.model.effects import Ended
from pirate_sm.runtime.pump import BackendRaisedError, Pump, described


class AbandonOnError:
    """Sends the safe array past the engine when a step breaks, and says so by our own errors."""

    def __init__(self, pump: Pump, backend: str) -> None:
        self._pump = pump
        self._backend = backend

    def __enter__(self) -> None:
        """Begin."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Abandon the run if anything was raised.

        Raises:
            BackendError: It was the backend that raised.
        """
        if error is None or self._pump.ended is not None:
            return
        if isinstance(error, BackendRaisedError):
            message = f"the {self._backend} backend failed: {described(error.__cause__)}"
            self._pump.abandon(Ended("fault", message))
            raise BackendError(message) from error.__cause__
        self._pump.abandon(Ended("interrupted", described(error)))
