"""Ends a look at a robot when a stop is requested."""

from __future__ import annotations

from collections.abc import Callable

from pirate_sm.running.runtime.ending import Stop, StopRequests


class StoppedError(Exception):
    """Is raised to end a command when a stop is requested."""

    def __init__(self, stop: Stop) -> None:
        super().__init__(stop.reason)
        self.exit_code = stop.exit_code


def stopper(requests: StopRequests) -> Callable[[], None]:
    """Return a check that raises once when a stop is requested; cleaning up is then undisturbed."""
    raised = False

    def check() -> None:
        nonlocal raised
        if requests.stop is not None and not raised:
            raised = True
            raise StoppedError(requests.stop)

    return check
