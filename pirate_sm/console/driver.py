"""A terminal whose stop key is heard by the thread that reads it, however busy the rest is."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from textual.drivers.linux_driver import LinuxDriver
from textual.events import Key
from textual.message import Message

STOP_KEY = "space"


@runtime_checkable
class Stoppable(Protocol):
    """Can be stopped from any thread."""

    def stop_now(self) -> None:
        """The robot is on its way to its safe state."""
        ...


class StopDriver(LinuxDriver):
    """Hands the stop key to the app at once, past its queue."""

    def process_message(self, message: Message) -> None:
        """The message has been passed on, or has stopped the robot."""
        if (
            isinstance(message, Key)
            and message.key == STOP_KEY
            and isinstance(self._app, Stoppable)
        ):
            self._app.stop_now()
            return
        super().process_message(message)
