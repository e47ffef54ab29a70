"""Bring the robot to its safe state when a step of a pump raises."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pirate_sm.core.effects import Ended
from pirate_sm.core.errors import BackendError, DetectorError
from pirate_sm.running.runtime.loop import raised_by_part
from pirate_sm.running.runtime.pump import BackendRaisedError, Pump, described


@contextmanager
def abandoned_on_error(pump: Pump, backend: str) -> Iterator[None]:
    """Send the safe array past the engine if a step breaks, and say so by our own errors.

    Raises:
        BackendError: It was the backend of this name that raised.
        DetectorError: It was a detector of another package.
    """
    try:
        yield
    except BaseException as error:
        if pump.ended is not None:
            raise
        cause = raised_by_part(error)
        if isinstance(cause, DetectorError):
            pump.abandon(Ended("fault", str(cause)))
            raise cause from None
        if isinstance(error, BackendRaisedError):
            message = f"the {backend} backend failed: {described(cause)}"
            pump.abandon(Ended("fault", message))
            raise BackendError(message) from cause
        pump.abandon(Ended("interrupted", described(error)))
        raise
