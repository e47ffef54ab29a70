"""Actions of a guardian: write to the port, send a note to the runner, reopen, end."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from pirate_sm.robot.backends.serial.guardian.notes import Note


class ToPort(NamedTuple):
    """Write these bytes to the port in one call."""

    data: bytes


class ToRunner(NamedTuple):
    """Send this note to the runner."""

    note: Note


class Reopen(NamedTuple):
    """Open the port again."""


class EndGuardian(NamedTuple):
    """End the guardian.

    Attributes:
        stopped: Whether the robot is known to be stopped, or was never set in motion.
    """

    stopped: bool = True


Action: TypeAlias = ToPort | ToRunner | Reopen | EndGuardian
