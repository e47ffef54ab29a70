"""Bring the robot to its safe state when a step of a pump raises."""

from __future__ import annotations

from types import TracebackType

from pirate_sm.errors import BackendError, DetectorError
from pirate_sm.model.effects import Ended
from pirate_sm.runtime.loop import raised_by_part
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
            DetectorError: It was a detector of another package.
        """
        if error is None or self._pump.ended is not None:
            return
        cause = raised_by_part(error)
        if isinstance(cause, DetectorError):
            self._pump.abandon(Ended("fault", str(cause)))
            raise cause
        if isinstance(error, BackendRaisedError):
            message = f"the {self._backend} backend failed: {described(cause)}"
            self._pump.abandon(Ended("fault", message))
            raise BackendError(message) from cause
        self._pump.abandon(Ended("interrupted", described(error)))
