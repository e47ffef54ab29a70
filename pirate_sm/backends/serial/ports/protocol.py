"""What the driver asks of a serial port, so that a virtual one can stand in for it."""

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
        """Seconds that never go back."""
        ...

    def open(self) -> None:
        """It is ours alone.

        Raises:
            BackendError: It is not; the message says what to do about it.
        """
        ...

    def reopen(self) -> bool:
        """Whether a port that was lost is ours again; returns soon."""
        ...

    def write(self, data: bytes) -> None:
        """The bytes have been handed over in one piece.

        Raises:
            PortLostError: There is nobody to hand them to.
        """
        ...

    def read(self, until_s: float) -> bytes:
        """What has come, as soon as anything has; empty when nothing had by then.

        Raises:
            PortLostError: Nothing will come any more.
        """
        ...

    def wait(self, until_s: float) -> None:
        """It is that time; for when there is nothing to read from."""
        ...

    def beat(self, safe_frame: bytes) -> None:
        """Whoever guards the port knows that we live, and what to send when we do not."""
        ...

    def overruled(self) -> bool:
        """Whether a guard has acted in our place since this was last asked."""
        ...

    def remark(self) -> str:
        """Return what a person must know about who has had or keeps the port, once; else empty."""
        ...

    def close(self, stopped: bool = False) -> None:
        """Let the port go once everything written has gone out; never raises.

        Args:
            stopped: Whether the robot is known to be stopped, or was never set in motion. Else
                whoever guards the port keeps it until the robot has confirmed the safe array.
        """
        ...
