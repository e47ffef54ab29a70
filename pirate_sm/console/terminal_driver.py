"""A terminal whose stop key is heard by the thread that reads it, however busy the rest is.

And one that may go away: what is written to it then is lost, and nobody waits for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, TextIO, runtime_checkable

from textual.drivers.linux_driver import LinuxDriver
from textual.events import Key
from textual.message import Message

STOP_KEY = "space"


@runtime_checkable
class Stoppable(Protocol):
    """Can be stopped from any thread."""

    def stop_now(self) -> None:
        """Send the robot to its safe state."""
        ...

    def leave_now(self) -> None:
        """Send the robot to its safe state and leave, because the terminal has gone."""
        ...


class StopDriver(LinuxDriver):
    """Hands the stop key to the app past its queue; tells it when the terminal has gone."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # Textual's writing thread dies of an error, and then everybody who writes waits for it.
        self._file: TextIO = Lossy(self._file, self._gone)  # type: ignore[assignment]

    def process_message(self, message: Message) -> None:
        """Pass the message on; the stop key stops the robot instead."""
        if (
            isinstance(message, Key)
            and message.key == STOP_KEY
            and isinstance(self._app, Stoppable)
        ):
            self._app.stop_now()
            return
        super().process_message(message)

    def _gone(self) -> None:
        if isinstance(self._app, Stoppable):
            self._app.leave_now()


class Lossy:
    """A file that goes on taking text when it can no longer be written.

    Args:
        file: The file.
        gone: Is called when that has turned out, once.
    """

    def __init__(self, file: TextIO, gone: Callable[[], None]) -> None:
        self._file = file
        self._gone = gone
        self._lost = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def write(self, text: str) -> int:
        """Write the text, or drop it."""
        self._try(lambda: self._file.write(text))
        return len(text)

    def flush(self) -> None:
        """Flush the file, if it can still be written."""
        self._try(self._file.flush)

    def _try(self, work: Callable[[], object]) -> None:
        if self._lost:
            return
        try:
            work()
        except (OSError, ValueError):
            self._lost = True
            self._gone()
