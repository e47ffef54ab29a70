"""Addresses of the detector's socket, and how a socket is opened there."""

from __future__ import annotations

import errno
import os
import re
import socket
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path

from pirate_sm.core.errors import UsageError

_FORM = "expected socket:HOST:PORT on this machine's loopback, or socket:/PATH"
_HIGHEST_PORT = 65535
_USUAL_FILE = "pirate_sm.detector"


@dataclass(frozen=True)
class Address:
    """Where programs connect: a Unix socket's ``path``, or ``host`` and ``port``."""

    host: str = ""
    port: int = 0
    path: str = ""

    def __str__(self) -> str:
        return self.path or (f"[{self.host}]" if ":" in self.host else self.host) + f":{self.port}"


def read_address(text: str | None) -> Address:
    """Return the address in ``HOST:PORT`` or ``/PATH``; without a text the user's Unix socket.

    Raises:
        UsageError: It is neither, or other machines could reach it.
    """
    if not text:
        return _usual_address()
    if text.startswith("/"):
        return Address(path=text)
    host, _, port = text.rpartition(":")
    host = "127.0.0.1" if host == "localhost" else host.removeprefix("[").removesuffix("]")
    if not (re.fullmatch("[0-9]{1,9}", port) and 0 < int(port) <= _HIGHEST_PORT):
        raise UsageError(f"socket:{text}: {_FORM}")
    try:
        inside = ip_address(host).is_loopback
    except ValueError:
        raise UsageError(f"socket:{text}: {_FORM}") from None
    if not inside:
        raise UsageError(
            f"socket:{text}: any machine that reaches {host} could steer the robot; "
            "use 127.0.0.1, ::1 or socket:/PATH"
        )
    return Address(host, int(port))


def _usual_address() -> Address:
    folder = os.environ.get("XDG_RUNTIME_DIR", "")
    if not folder:
        message = "XDG_RUNTIME_DIR, the folder for a user's sockets, is not set; name a file"
        raise UsageError(f"socket: {message}: socket:/PATH")
    return Address(path=str(Path(folder, _USUAL_FILE)))


def open_socket(address: Address) -> tuple[socket.socket, Address]:
    """Return a socket that listens, and its address with the assigned port instead of 0.

    Raises:
        UsageError: The address cannot be used.
    """
    try:
        if address.path:
            return _unix_socket(Path(address.path)), address
        listening = _tcp_socket(address)
    except OSError as error:
        raise UsageError(f"socket:{address}: {_reason(address, error)}") from None
    return listening, Address(address.host, listening.getsockname()[1])


def _reason(address: Address, error: OSError) -> str:
    """Return why an address cannot be used."""
    if error.errno != errno.EADDRINUSE:
        return os.strerror(error.errno) if error.errno else str(error)
    if address.path and not Path(address.path).is_socket():
        return "this is not a socket, so it is left alone; name a file that does not exist"
    return "a run or another program listens here already; end it, or name another address"


def _tcp_socket(address: Address) -> socket.socket:
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    listening = socket.create_server((address.host, address.port), family=family)
    listening.setblocking(False)
    return listening


def _unix_socket(path: Path) -> socket.socket:
    """Return a socket whose file only this user can write to; replace an unused file."""
    listening = socket.socket(socket.AF_UNIX)
    try:
        if path.is_socket() and not _answers(path):
            path.unlink()
        listening.bind(str(path))
        path.chmod(0o600)  # nobody can connect before it listens
        listening.listen()
        listening.setblocking(False)
    except OSError:
        listening.close()
        raise
    return listening


def _answers(path: Path) -> bool:
    with socket.socket(socket.AF_UNIX) as probe:
        return probe.connect_ex(str(path)) == 0
