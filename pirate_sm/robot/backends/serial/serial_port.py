"""A real serial port, by any URL that pyserial accepts."""

from __future__ import annotations

import errno
import os
import re
import time
from contextlib import suppress
from pathlib import Path

from pirate_sm.core.errors import BackendError, not_installed
from pirate_sm.core.on_disk import is_file, is_folder
from pirate_sm.robot.backends.serial.port import PortLostError

try:
    import serial
    from serial.tools import list_ports
except ModuleNotFoundError:
    raise not_installed("the serial backend", "pyserial", "serial") from None

_WRITE_WITHIN_S = 0.5
_MOST_BYTES = 4096
_NO_ADDRESS = "{} is not an address that pyserial can use, such as socket://HOST:PORT"
_NOT_THERE = {errno.ENOENT, errno.ENOTDIR, errno.ELOOP, errno.ENAMETOOLONG}
_NO_PORT = {errno.ENOTTY, errno.EINVAL, errno.EISDIR, errno.ENXIO, errno.EIO, errno.ENODEV}
_NOT_REACHED = {errno.EHOSTUNREACH, errno.ENETUNREACH, errno.ETIMEDOUT, errno.EHOSTDOWN}


class SerialPort:
    """A port, locked against every other program that locks it too.

    Args:
        url: A device such as ``/dev/ttyACM0``, or any URL of pyserial.
        baud: Baud rate of the line.
    """

    def __init__(self, url: str, baud: int) -> None:
        self.name = url
        self._baud = baud
        self._port: serial.Serial | None = None
        self.epoch_s = time.time() - time.monotonic()

    now = staticmethod(time.monotonic)

    def open(self) -> None:
        """Open and lock the port."""
        if not self.name.strip():
            raise BackendError("the name of the port is empty")
        try:
            self._port = serial.serial_for_url(
                self.name,
                baudrate=self._baud,
                timeout=0,
                write_timeout=_WRITE_WITHIN_S,
                exclusive=True,
            )
        except ValueError as error:
            raise BackendError(f"{self.name} cannot be a serial port: {error}") from None
        except (serial.SerialException, OSError) as error:
            raise BackendError(_advice(self.name, error)) from None
        except Exception:  # pyserial raises anything on bad options in URLs
            raise BackendError(_NO_ADDRESS.format(self.name)) from None

    def write(self, data: bytes) -> None:
        """Write the bytes in one piece."""
        if self._port is None:
            raise PortLostError(f"{self.name} is closed")
        try:
            self._port.write(data)
        except (serial.SerialException, OSError) as error:
            self.let_go()  # a replugged device gets its old name only then
            raise PortLostError(f"{self.name} cannot be written to: {error}") from None

    def read(self) -> bytes:
        """Return the bytes that have been received; empty if there are none."""
        if self._port is None:
            raise PortLostError(f"{self.name} is closed")
        try:
            return bytes(self._port.read(_MOST_BYTES))
        except (serial.SerialException, OSError, TypeError):
            # pyserial raises a TypeError when its descriptor is closed meanwhile.
            self.let_go()
            raise PortLostError(f"{self.name} has gone") from None

    @property
    def descriptor(self) -> int:
        """The descriptor to wait for; -1 for a port that can only be polled, such as loop://."""
        try:
            return self._port.fileno() if self._port is not None else -1
        except (AttributeError, OSError):
            return -1

    def close(self) -> None:
        """Close the port once all written bytes have gone out."""
        if self._port is not None:
            with suppress(Exception):  # the port may have gone
                self._port.flush()
        self.let_go()

    def let_go(self) -> None:
        """Close the port at once and drop unsent bytes."""
        if self._port is not None:
            with suppress(Exception):
                self._port.close()
        self._port = None


def _advice(name: str, error: OSError) -> str:
    """Return why a port cannot be opened, and what to do."""
    code = error.errno
    within = re.search(r"(?:\(|\[Errno )(\d+)[],]", str(error))
    if code is None and within:
        code = int(within[1])  # pyserial puts some error codes into its text
    if code is None and "exclusively lock" in str(error):
        code = errno.EBUSY
    if "://" in name:
        return _no_answer(name, code, error)
    if code in _NOT_THERE:
        found = ", ".join(sorted(port.device for port in list_ports.comports()))
        there = f"there are {found}" if found else "there is none at all: is it plugged in?"
        return f"there is no port {name}; {there}"
    if code in {errno.EACCES, errno.EPERM}:
        group = _group(name)
        join = f" (on Linux: sudo usermod -a -G {group} $USER, then log in again)" if group else ""
        return f"you may not use {name}: join the group that owns it{join}"
    if code in {errno.EBUSY, errno.EAGAIN}:
        return f"{name} is in use by another program: close it, or wait until its mission has ended"
    if is_folder(Path(name)):
        return f"{name} is a directory and no serial port"
    if is_file(Path(name)):
        return f"{name} is a file and no serial port"
    if code in _NO_PORT:
        return f"{name} is not a serial port, or nothing is connected to it"
    return f"{name} cannot be opened: {error}"


def _no_answer(name: str, code: int | None, error: OSError) -> str:
    """Return why nothing answers at an address."""
    if code == errno.ECONNREFUSED:
        return f"nothing listens at {name}: is the program there running?"
    if code in _NOT_REACHED or "timed out" in str(error):
        return f"{name} cannot be reached: is the host on, and in this network?"
    if "[Errno -" in str(error):
        return f"{name} cannot be reached: its host has no known address"
    if name.startswith(("socket://", "rfc2217://")):
        return _NO_ADDRESS.format(name)
    return f"{name} cannot be opened: {error}"


def _group(name: str) -> str:
    """Return the name of the group that owns the port; empty if there is none."""
    with suppress(ImportError, OSError, KeyError):
        import grp  # noqa: PLC0415 - not on every system

        return grp.getgrgid(os.stat(name).st_gid).gr_name  # noqa: PTH116 - may be no path
    return ""
