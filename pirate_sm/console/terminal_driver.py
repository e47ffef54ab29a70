"""A terminal driver whose stop key works however busy the app is.

The terminal may also go away: output is then lost, nothing blocks on it, and the app leaves.
"""

from __future__ import annotations

import os
import select
from codecs import getincrementaldecoder
from collections.abc import Callable
from typing import Any, Protocol, TextIO, runtime_checkable

from textual._xterm_parser import XTermParser
from textual.drivers.linux_driver import LinuxDriver
from textual.events import Key
from textual.message import Message

STOP_KEY = "space"

_LOOK_EVERY_S = 0.1


@runtime_checkable
class Leaving(Protocol):
    """Leaves when asked to from any thread."""

    def leave_now(self) -> None:
        """Bring the robot, if there is one, to its safe state and leave: the terminal has gone."""


@runtime_checkable
class Stoppable(Leaving, Protocol):
    """Can be stopped from any thread.

    Attributes:
        typing: Whether the stop key is a letter of a text, because nothing moves.
    """

    @property
    def typing(self) -> bool:
        """Return whether a text is being typed."""

    def stop_now(self) -> None:
        """Send the robot to its safe state."""


class StopDriver(LinuxDriver):
    """Passes the stop key to the app past its queue, and reports the loss of the terminal."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # Textual's writing thread dies of an error, and all writers would then block.
        self._file: TextIO = Lossy(self._file, self._gone)  # type: ignore[assignment]

    def process_message(self, message: Message) -> None:
        """Pass the message on; for the stop key, stop the robot instead."""
        if (
            isinstance(message, Key)
            and message.key == STOP_KEY
            and isinstance(self._app, Stoppable)
            and not self._app.typing
        ):
            self._app.stop_now()
            return
        super().process_message(message)

    def run_input_thread(self) -> None:
        """Pass on what is typed until the app leaves; at the end of input, make it leave.

        Textual's own loop takes the end of input for a pause in it, and reads it again at once.
        """
        parser, decoder = XTermParser(self._debug), getincrementaldecoder("utf-8")("replace")
        while not self.exit_event.is_set():
            typed = self._typed()
            if typed == b"":
                self._gone()
                return
            text = decoder.decode(typed or b"")
            for message in (*(parser.feed(text) if text else ()), *parser.tick()):
                self.process_message(message)

    def _typed(self) -> bytes | None:
        """Return what has been typed: nothing at the end of input, None if no key was pressed."""
        try:
            if not select.select([self.fileno], [], [], _LOOK_EVERY_S)[0]:
                return None
            return os.read(self.fileno, 4096)
        except (OSError, ValueError):
            return b""

    def _gone(self) -> None:
        if isinstance(self._app, Leaving):
            self._app.leave_now()


class Lossy:
    """A file that accepts text even when it can no longer be written.

    Args:
        file: The file.
        gone: Is called once, when a write has failed.
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
