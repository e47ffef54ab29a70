"""Reads a panel's device in a thread, so that a stop waits for nothing else."""

from __future__ import annotations

import os
import select
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from math import inf
from pathlib import Path
from threading import Thread
from typing import Literal, NamedTuple, Self, TypeAlias

from pirate_sm.core.errors import UsageError
from pirate_sm.core.panel import Panel, RunButton
from pirate_sm.robot.control_panel.control_changes import ControlChangeParser
from pirate_sm.robot.control_panel.midi_devices import MidiSystem, open_device, read_device
from pirate_sm.robot.control_panel.presses import Press, Presses

REOPEN_EVERY_S = 1.0

MOST_WAITING = 100
"""Nobody presses so often between two looks; the oldest are dropped."""

EndRun: TypeAlias = Callable[[str], None]
"""Brings the robot to its safe state, for this reason; may be called from any thread."""


class Connection(NamedTuple):
    """The panel was lost, or is back.

    Attributes:
        state: Which of the two.
        message: What has happened, for people.
    """

    state: Literal["lost", "back"]
    message: str


Happening: TypeAlias = Press | Connection


class PanelReader:
    """A connected panel, while it is entered.

    Presses that end the run act in the reader's thread; all others wait for :meth:`taken`.

    Args:
        panel: The panel.
        device: Its file; None: found by the name of its sound card.
        end_run: Ends the run.
        reopen_every_s: How often a device that has gone is looked for.

    Attributes:
        panel: The panel.
    """

    def __init__(
        self,
        panel: Panel,
        device: Path | None,
        end_run: EndRun,
        *,
        reopen_every_s: float = REOPEN_EVERY_S,
    ) -> None:
        self.panel = panel
        self._device = device
        self._end_run = end_run
        self._system = MidiSystem()
        self._reopen_every_s = reopen_every_s
        self._happened: deque[Happening] = deque(maxlen=MOST_WAITING)
        self._presses = Presses(panel)
        self._parser = ControlChangeParser()
        self._fd = self._wake = self._woken = -1
        self._thread = Thread(target=self._work, name="panel", daemon=True)

    def __enter__(self) -> Self:
        """Open the device and begin to read.

        Raises:
            UsageError: The device is not there or cannot be opened.
        """
        self._fd = self._open()
        self._woken, self._wake = os.pipe()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop reading and close the device."""
        os.close(self._wake)
        self._thread.join()
        os.close(self._woken)
        self._close()

    def taken(self) -> list[Happening]:
        """Return what has happened since the last call, oldest first."""
        found = []
        while self._happened:
            found.append(self._happened.popleft())
        return found

    # --- in its own thread --------------------------------------------------------------------

    def _open(self) -> int:
        return open_device(self._device or self._system.find(self.panel.device))

    def _close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _work(self) -> None:
        try:
            while self._turn():
                pass
        except Exception as error:
            self._lose(f"this program has failed to read it: {type(error).__name__}: {error}")

    def _turn(self) -> bool:
        """Wait for bytes, for a held button or for the device; return whether to go on."""
        poll = select.poll()
        poll.register(self._woken, select.POLLIN)
        if self._fd >= 0:
            poll.register(self._fd, select.POLLIN)
            wait_s = max(self._presses.due_s - time.monotonic(), 0.0)
        else:
            wait_s = self._reopen_every_s
        ready = dict(poll.poll(None if wait_s == inf else wait_s * 1000))
        if self._woken in ready:
            return False
        if self._fd < 0:
            self._look_for_it()
            return True
        if self._fd in ready:
            self._read()
        for press in self._presses.pass_time(time.monotonic()):
            self._act(press)
        return True

    def _read(self) -> None:
        data = read_device(self._fd)
        if isinstance(data, str):
            self._lose(data)
            return
        for change in self._parser.take(data):
            for press in self._presses.take(change, time.monotonic()):
                self._act(press)

    def _act(self, press: Press) -> None:
        button = press.button
        if isinstance(button, RunButton) and button.do in ("stop", "abort") and not press.asks:
            self._end_run(f"{'stopped' if button.do == 'stop' else 'aborted'} on the panel")
        else:
            self._happened.append(press)

    def _lose(self, why: str) -> None:
        self._close()
        self._presses.release_all()
        self._parser = ControlChangeParser()
        self._happened.append(Connection("lost", f"the panel is disconnected: {why}"))

    def _look_for_it(self) -> None:
        with suppress(UsageError):
            self._fd = self._open()
            self._happened.append(Connection("back", "the panel is back"))
