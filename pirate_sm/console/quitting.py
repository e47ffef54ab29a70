"""Requests of the operator to stop or leave, for all runs of a session."""

from __future__ import annotations

from pirate_sm.runtime.stop_requests import Stop, StopRequests


class Quitting(StopRequests):
    """Requests that end the session with its present run; signals make them too."""

    def __init__(self) -> None:
        super().__init__()
        self.run = StopRequests()

    def begin(self) -> StopRequests:
        """Return the requests of the next run, with a stop if the session was asked to stop."""
        self.run = StopRequests()
        if self.stop is not None:
            self.run.ask(self.stop)
        return self.run

    def ask(self, stop: Stop) -> None:
        """End the present run through the engine's safe stop; no run follows."""
        super().ask(stop)
        self.run.ask(stop)

    def insist(self) -> None:
        """End it at once, with the safe array sent past the engine."""
        super().insist()
        self.run.insist()
