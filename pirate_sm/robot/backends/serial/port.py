"""The protocol of a serial port, which a virtual one implements as well."""

from __future__ import annotations

from typing import Protocol

from pirate_sm.core.errors import BackendError


class PortLostError(BackendError):
    """Is raised when an open port has gone: unplugged, or its other end closed."""


class Port(Protocol):
    """A serial port and the clock that goes with it.

    Attributes:
        name: Name of the port, as people use it.
        epoch_s: Added to its clock gives seconds since 1970.
    """

    @property
    def name(self) -> str:
        """Name of the port, as people use it."""

    @property
    def epoch_s(self) -> float:
        """Added to its clock gives seconds since 1970."""

    def now(self) -> float:
        """Return the time of the port's clock, s; it never goes back."""

    def open(self) -> None:
        """Open the port for this program alone.

        Raises:
            BackendError: It cannot be opened; the message says what to do.
        """

    def reopen(self) -> bool:
        """Try once to reopen a lost port; return whether it is open."""

    def write(self, data: bytes) -> None:
        """Write the bytes in one piece.

        Raises:
            PortLostError: The port has gone.
        """

    def read(self, until_s: float) -> bytes:
        """Return received bytes as soon as there are any; empty if none came by ``until_s``.

        Raises:
            PortLostError: The port has gone.
        """

    def wait(self, until_s: float) -> None:
        """Sleep until that time, when there is nothing to read from."""

    def beat(self, safe_frame: bytes) -> None:
        """Send the guardian a sign of life and the frame to send if these signs stop."""

    def overruled(self) -> bool:
        """Return whether the guardian has acted instead of this program since the last call."""

    def remark(self) -> str:
        """Return, once, what a person must know about other users of the port; else empty."""

    def close(self, stopped: bool = False) -> None:
        """Close the port once all written bytes have gone out; never raises.

        Args:
            stopped: Whether the robot is known to be stopped, or was never set in motion. If not,
                the guardian keeps the port until the robot has confirmed the safe array.
        """
