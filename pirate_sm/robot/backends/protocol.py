"""What every backend must do; :mod:`pirate_sm.testing` holds each of them to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol, TypeAlias, runtime_checkable

from pirate_sm.core.events import Event, WordWatch
from pirate_sm.core.sensing import Glide, Watch

Completion: TypeAlias = Literal["measured", "nominal"]


class Backend(Protocol):
    """Takes setpoint arrays and reports what happens to them and to the robot.

    Attributes:
        name: Name of the backend, as users give it.
        completion: ``measured``: sensors show when a command is done. ``nominal``: nothing moves,
            and a command counts as done after its nominal duration.
        real_time: Whether ``advance`` takes as long as the time by which it advances.
    """

    @property
    def name(self) -> str:
        """Name of the backend, as users give it."""

    @property
    def completion(self) -> Completion:
        """How a command is found to be done."""

    @property
    def real_time(self) -> bool:
        """Whether ``advance`` runs in real time."""

    def open(self) -> Sequence[Event]:
        """Make the backend ready without moving anything; return the events known at the start.

        Raises:
            BackendError: The backend cannot be made ready.
        """

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """Take an array; ``advance`` reports exactly one ``SubmitResult`` for it later.

        Never blocks. The newest array wins. An array that is still unsent when a newer one is
        submitted is never sent, and its result is ``superseded``. The newest is sent as soon as the
        backend can send. A sent array ends as ``accepted``, or as ``unknown`` if a newer one was
        sent before it was confirmed; it is not repeated after the newer one. No array is accepted
        after a newer one. Submitting the same id again repeats the same array.

        Args:
            setpoint_id: Id of the array.
            values: One value per slot, duty cycle -1..1 or angle in rad.

        Raises:
            BackendError: The backend can take no more arrays.
        """

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """Let time run until ``until_s``, or until there is an event to report.

        Args:
            until_s: Seconds since the run began; may be infinite.

        Returns:
            The time reached, never less than in the last call, and the events at that time.

        Raises:
            BackendError: The backend has failed in a way that no event can report.
        """

    def close(self) -> None:
        """Send the last array submitted and release everything.

        It may be called more than once and after any error. It never raises.
        """


@runtime_checkable
class Gliding(Protocol):
    """A backend that can take frames for the engine, as long as they change nothing but signals."""

    def places_m(self) -> Sequence[float]:
        """Return the position of each wheel along the pipe, by which it can look for a detector."""

    def glide(self, watch: Watch, until_s: float, words: WordWatch | None = None) -> Glide | None:
        """Let time run while every frame is quiet, as :class:`Watch` tells.

        A frame that is not quiet is the first event of the next ``advance``, with its time.

        Args:
            watch: What must stay true.
            until_s: Seconds since the run began; time stays below it.
            words: What a detector knows that looks by :meth:`places_m`. Time stays below the first
                look at which it would have something to say; None without a detector.

        Returns:
            What has passed; None if nothing has.
        """
