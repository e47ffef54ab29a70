"""The bay on a pseudo-terminal, in real time: any program can open it as a serial port."""

from __future__ import annotations

import json
import os
import select
import signal
import termios
import time
import tty
from collections.abc import Callable
from contextlib import suppress
from errno import EEXIST
from pathlib import Path
from types import FrameType
from typing import Self, TextIO

from pirate_sm.core.errors import BackendError, UsageError
from pirate_sm.simulation.bay.firmware import Record
from pirate_sm.simulation.bay.virtual import VirtualBay

# Short beside the firmware's cases of 4 ms.
_PAUSE_S = 0.001
_READ_AT_ONCE = 4096
# Indices of the speeds in the result of `termios.tcgetattr`.
_SPEEDS = slice(4, 6)
_AT_ANOTHER_RATE = bytes((byte * 3 + 0x5B) % 256 for byte in range(256))
"""How each byte reads at a wrong baud rate; never as a frame."""


class Terminal:
    """A pseudo-terminal whose other end a host opens; a context manager.

    Args:
        link: Path for a symbolic link to it; a dead one there is replaced.
        baud: Baud rate of the device. A host that sets another rate sends and reads garbage; one
            that sets none does not. None, or a rate that has no constant here: any rate works.

    Attributes:
        name: Path of the end that a host opens.

    Raises:
        UsageError: The link cannot be made.
        BackendError: No pseudo-terminal is available.
    """

    def __init__(self, link: Path | None = None, baud: int | None = None) -> None:
        self._speed: int | None = getattr(termios, f"B{baud}", None)
        try:
            self._ours, theirs = os.openpty()
        except OSError as error:
            raise BackendError(f"no pseudo-terminal: {error.strerror}") from None
        self.name = os.ttyname(theirs)
        tty.setraw(theirs)
        self._set_speed()
        # From now on a hang-up shows whether a host has it open.
        os.close(theirs)
        os.set_blocking(self._ours, False)
        self._poll = select.poll()
        self._poll.register(self._ours, select.POLLIN)
        self._link = link
        if link is not None:
            self._make_link(link)

    def _make_link(self, link: Path) -> None:
        try:
            if link.is_symlink():
                if link.exists() and str(link.readlink()) != self.name:
                    why = f"it leads to {link.readlink()}, which is in use: end the bay there, or"
                    raise FileExistsError(EEXIST, f"{why} remove the link if that is not a bay")
                link.unlink()
            link.symlink_to(self.name)
        except OSError as error:
            self._link = None
            self.close()
            raise UsageError(f"no link can be made at '{link}': {error.strerror}") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the pseudo-terminal and remove the link to it."""
        os.close(self._ours)
        if self._link is not None and self._link.is_symlink():
            with suppress(OSError):
                if str(self._link.readlink()) == self.name:
                    self._link.unlink()

    def wait(self, patience_s: float) -> tuple[bool, bytes]:
        """Wait at most this long; return whether a host has it open, and what it has written."""
        events = dict(self._poll.poll(patience_s * 1000.0)).get(self._ours, 0)
        data = b""
        if events & select.POLLIN:
            with suppress(OSError):  # the host has gone meanwhile
                data = self._at_rate(os.read(self._ours, _READ_AT_ONCE))
        return not events & select.POLLHUP, data

    def write(self, data: bytes) -> None:
        """Let the host read the bytes; what does not fit is lost, as on the real port."""
        with suppress(OSError):
            os.write(self._ours, self._at_rate(data))

    def _at_rate(self, data: bytes) -> bytes:
        """Return the bytes as read at the device's rate, if they were sent at the host's."""
        if self._speed is None or termios.tcgetattr(self._ours)[_SPEEDS] == [self._speed] * 2:
            return data
        return data.translate(_AT_ANOTHER_RATE)

    def _set_speed(self) -> None:
        """Set the port to the device's rate."""
        if self._speed is not None:
            settings = termios.tcgetattr(self._ours)
            settings[_SPEEDS] = [self._speed] * 2
            termios.tcsetattr(self._ours, termios.TCSANOW, settings)

    def renew(self) -> None:
        """Discard the bytes and the rate that the last host has left."""
        with suppress(termios.error):
            termios.tcflush(self._ours, termios.TCIOFLUSH)
            self._set_speed()


class StopSignals:
    """Makes SIGINT, SIGTERM and SIGHUP end the bay instead of the process; a context manager.

    A signal that this process ignored at its start (``nohup``) stays ignored.

    Attributes:
        stop: Whether a signal has come.
    """

    def __init__(self) -> None:
        self.stop = False
        self._before: dict[signal.Signals, object] = {}

    def __enter__(self) -> Self:
        for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(each) != signal.SIG_IGN:
                self._before[each] = signal.signal(each, self._hear)
        return self

    def __exit__(self, *_: object) -> None:
        for each, before in self._before.items():
            signal.signal(each, before)  # type: ignore[arg-type]

    def _hear(self, number: int, frame: FrameType | None) -> None:
        self.stop = True


def serve(
    bay: VirtualBay,
    terminal: Terminal,
    stopped: Callable[[], bool],
    log: TextIO | None = None,
    clock: Callable[[], float] = time.monotonic,
) -> None:
    """Run the bay in real time until it should stop.

    Args:
        bay: The bay, just switched on.
        terminal: The terminal that hosts open.
        stopped: Returns whether the bay should stop.
        log: Takes a line of JSON for each record.
        clock: Returns the time, s.
    """
    began = clock()
    connected = False
    while not stopped():
        there, data = terminal.wait(_PAUSE_S)
        now = clock() - began
        if there and not connected:
            bay.open(now)
        elif connected and not there:
            bay.close(now)
            terminal.renew()
        connected = there
        if data:
            bay.receive(data, now)
        out = bay.advance(now)
        if out:
            terminal.write(out)
        write_log(bay.records, log)
        if not there:
            # A hang-up makes every wait return at once.
            time.sleep(_PAUSE_S)


def write_log(records: list[Record], log: TextIO | None) -> None:
    """Write the records to the log and clear the list."""
    if log is not None and records:
        log.writelines(line_of(record) for record in records)
        log.flush()
    records.clear()


def line_of(record: Record) -> str:
    """Return the record as a line of JSON, without its empty fields."""
    line: dict[str, object] = {"at_s": round(record.at_s, 6), "event": record.event}
    if record.setpoint_id is not None:
        line |= {"id": record.setpoint_id, "setpoints": list(record.counts)}
    if record.detail:
        line["detail"] = record.detail
    return json.dumps(line) + "\n"
