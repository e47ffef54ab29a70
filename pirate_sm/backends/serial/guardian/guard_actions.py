"""What a guardian decides to do: bytes to the port, notes to the runner, reopening, its own end."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from pirate_sm.backends.serial.guardian.notes import Note


class ToPort(NamedTuple):
    """Bytes to be written in one call."""

    data: bytes


class ToRunner(NamedTuple):
    """A note to be passed on to the runner."""

    note: Note


class Reopen(NamedTuple):
    """An order to open the port again."""


class EndGuardian(NamedTuple):
    """An order to end the guardian.

    Attributes:
        stopped: Whether the robot is known to be stopped, or was never set in motion.
    """

    stopped: bool = True


Action: TypeAlias = ToPort | ToRunner | Reopen | EndGuardian
