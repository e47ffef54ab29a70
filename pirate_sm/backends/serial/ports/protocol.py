"""What a serial port must do, so that a virtual one can stand in for it."""

from __future__ import annotations

from typing import Protocol

from pirate_sm.errors import BackendError


class PortLostError(BackendError):
    """Is raised when a port that was open has gone: unplugged, or its other end closed."""


class Port(Protocol):
    """A serial port and the clock that goes with it.

    Attributes:
        name: What people call it.
        epoch_s: Added to its clock gives seconds since 1970.
    """

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    @property
    def epoch_s(self) -> float:
        """Added to its clock gives seconds since 1970."""
        ...

    def now(self) -> float:
        """Return the time of the port's clock, s; it never goes back."""
        ...

    def open(self) -> None:
        """Open the port for this program alone.

        Raises:
            BackendError: It is not; the message says what to do about it.
        """
        ...

    def reopen(self) -> bool:
        """Try to open a port that was lost, without waiting; return whether it is open."""
        ...

    def write(self, data: bytes) -> None:
        """Write the bytes in one piece.

        Raises:
            PortLostError: There is nobody to hand them to.
        """
        ...

    def read(self, until_s: float) -> bytes:
        """Return what has come, as soon as anything has; empty when nothing had by ``until_s``.

        Raises:
            PortLostError: Nothing will come any more.
        """
        ...

    def wait(self, until_s: float) -> None:
        """Sleep until that time; for when there is nothing to read from."""
        ...

    def beat(self, safe_frame: bytes) -> None:
        """Tell the port's guardian that this program lives, and what to send when it does not."""
        ...

    def overruled(self) -> bool:
        """Return whether the guardian has acted in place of this program since the last call."""
        ...

    def remark(self) -> str:
        """Return what a person must know about who has had or keeps the port, once; else empty."""
        ...

    def close(self, stopped: bool = False) -> None:
        """Close the port once everything written has gone out; never raises.

        Args:
            stopped: Whether the robot is known to be stopped, or was never set in motion. Else
                whoever guards the port keeps it until the robot has confirmed the safe array.
        """
        ...
