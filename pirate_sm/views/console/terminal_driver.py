"""A terminal driver whose stop key works however busy the app is.

The terminal may also go away: output is then lost, nothing blocks on it, and the app leaves.
"""

from __future__ import annotations

import os
import select
import sys
import termios
from codecs import getincrementaldecoder
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, Queue
from threading import Thread
from typing import Any, Protocol, TextIO, runtime_checkable

from textual._xterm_parser import XTermParser
from textual.drivers.linux_driver import LinuxDriver
from textual.events import Key
from textual.message import Message

STOP_KEY = "space"

_LOOK_EVERY_S = 0.1

_TAKES_WITHIN_S = 0.5
"""A terminal that has not taken the last output by then takes none."""


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
    """Passes the stop key to the app past its queue, and reports the loss of the terminal.

    Nothing waits for a terminal that takes no output: what it does not take is dropped, and all is
    drawn again when it does. Textual itself would wait, with every key but the stop.
    """

    _dropping = False

    def start_application_mode(self) -> None:
        """Take the terminal over, by a file that can do without it."""
        # Textual's writing thread dies of an error, and all writers would then block. With a file
        # of its own that thread keeps no lock that the rest of the program needs.
        own = os.fdopen(os.dup(self._file.fileno()), "w", encoding="utf-8", newline="")
        self._file: TextIO = Lossy(own, self._gone)  # type: ignore[assignment]
        with suppress(termios.error):  # what was typed before is for nothing on the screen
            termios.tcflush(self.fileno, termios.TCIFLUSH)
        super().start_application_mode()  # type: ignore[no-untyped-call]

    @property
    def _waiting(self) -> Queue[str | None]:
        assert self._writer_thread is not None
        return self._writer_thread._queue

    def write(self, data: str) -> None:
        """Write the data soon, or drop it while the terminal takes nothing."""
        if self._dropping and self._waiting.empty():
            self._dropping = False
            self._app.refresh(layout=True)
        self._dropping = self._dropping or self._waiting.full()
        if not self._dropping:
            super().write(data)

    def stop_application_mode(self) -> None:
        """Restore the terminal; no frame is needed any more."""
        with suppress(Empty):
            while True:
                self._waiting.get_nowait()
        self._dropping = False
        super().stop_application_mode()

    def close(self) -> None:
        """End writing; if the terminal takes nothing, do without it from now on."""
        if (writer := self._writer_thread) is not None:
            Thread(target=writer.stop, daemon=True).start()
            writer.join(_TAKES_WITHIN_S)
            if writer.is_alive():
                nowhere = os.open(os.devnull, os.O_WRONLY)
                for each in (sys.stdout, sys.stderr):
                    os.dup2(nowhere, each.fileno())
            else:
                with suppress(OSError):  # it has gone, with the rest of what was to be written
                    self._file.close()

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

        Textual's own loop takes the end of input for a pause in it, and reads it again immediately.
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
