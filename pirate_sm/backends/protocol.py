"""What every backend must do; :mod:`pirate_sm.testing` holds each of them to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol, TypeAlias

from pirate_sm.model.events import Event

Completion: TypeAlias = Literal["measured", "nominal"]


class Backend(Protocol):
    """Takes setpoint arrays and says what happens in its world.

    Attributes:
        name: What users call it.
        completion: ``measured``: its sensors tell when a command is done. ``nominal``: nothing
            moves, a command is taken as done after its nominal duration.
        real_time: Whether ``advance`` itself takes as long as the time that it passes.
    """

    @property
    def name(self) -> str:
        """What users call it."""
        ...

    @property
    def completion(self) -> Completion:
        """How commands are seen to be done."""
        ...

    @property
    def real_time(self) -> bool:
        """Whether time passes by itself."""
        ...

    def open(self) -> Sequence[Event]:
        """Make the backend ready without moving anything; return what it knows already.

        Raises:
            BackendError: It cannot be made ready.
        """
        ...

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """Hand an array over; exactly one ``SubmitResult`` for it follows from ``advance``.

        Never blocks. Arrays are a stream in which the newest wins. An array that has not been sent
        when a newer one is submitted is never sent and ends as ``superseded``; the newest is sent
        as soon as the backend can send. An array that has been sent ends as ``accepted``, or as
        ``unknown`` where a newer one had to be sent before it was confirmed; it is not sent again
        after the newer one. No array is accepted after a newer one. Submitting the same id again
        repeats the same array.

        Args:
            setpoint_id: Id of the array.
            values: One value per slot, duty cycle -1..1 or angle in rad.

        Raises:
            BackendError: The backend can no longer take anything.
        """
        ...

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """Let the world run until ``until_s``, or until there is something to say.

        Args:
            until_s: Seconds since the run began; may be infinite.

        Returns:
            The time reached, never before that of the last call, and the events of that moment.

        Raises:
            BackendError: The backend has broken beyond telling it by an event.
        """
        ...

    def close(self) -> None:
        """Send the last array submitted and release everything.

        May be called more than once and after any error; never raises.
        """
        ...
