"""A local socket on which several programs write lines; reading never blocks."""

from __future__ import annotations

import socket
import stat
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from ipaddress import ip_address
from pathlib import Path

from pirate_sm.detectors.socket_lines import LONGEST_LINE
from pirate_sm.errors import UsageError

_MOST_CLIENTS = 16
_AT_ONCE = 16 * LONGEST_LINE
"""Bytes read from one client in one turn; the rest waits for the next turn."""

_FORM = "expected socket:HOST:PORT on this machine's loopback, or socket:/PATH"
_HIGHEST_PORT = 65535


@dataclass(frozen=True)
class Address:
    """Where programs connect: a Unix socket's ``path``, or ``host`` and ``port``."""

    host: str = ""
    port: int = 0
    path: str = ""

    def __str__(self) -> str:
        return self.path or (f"[{self.host}]" if ":" in self.host else self.host) + f":{self.port}"


def read_address(text: str) -> Address:
    """Return the address in ``HOST:PORT`` or ``/PATH``.

    Raises:
        UsageError: It is neither, or other machines could reach it.
    """
    if text.startswith("/"):
        return Address(path=text)
    host, _, port = text.rpartition(":")
    host = "127.0.0.1" if host == "localhost" else host.removeprefix("[").removesuffix("]")
    if not (port.isascii() and port.isdecimal() and 0 < int(port[:9]) <= _HIGHEST_PORT):
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


@dataclass
class _Client:
    link: socket.socket
    begun: bytearray = field(default_factory=bytearray)


Answer = Callable[[bytes], bytes]
"""Takes a line and returns the answer to it; empty for none."""


class Listener:
    """Listens between ``open`` and ``close``.

    Attributes:
        address: The address; once open, with the assigned port in place of 0.
    """

    def __init__(self, address: Address) -> None:
        self.address = address
        self._door: socket.socket | None = None
        self._clients: list[_Client] = []

    def open(self) -> None:
        """Open the socket.

        Raises:
            UsageError: The address cannot be used.
        """
        there = self.address
        try:
            if there.path:
                self._door = _unix_door(Path(there.path))
            else:
                self._door = _tcp_door(there)
                self.address = Address(there.host, self._door.getsockname()[1])
        except OSError as error:
            raise UsageError(f"socket:{there}: {error.strerror or error}") from None

    def close(self) -> None:
        """Disconnect all programs and remove the socket's file; may be called twice."""
        for client in self._clients:
            client.link.close()
        self._clients.clear()
        if self._door is None:
            return
        self._door.close()
        self._door = None
        if self.address.path:
            with suppress(OSError):
                Path(self.address.path).unlink()

    def poll(self, answer: Answer) -> None:
        """Answer every complete line received; return at once if there is none."""
        self._let_in()
        self._clients = [client for client in self._clients if self._serve(client, answer)]

    def _let_in(self) -> None:
        while self._door is not None:
            try:
                link, _ = self._door.accept()
            except OSError:  # no client, or one that has gone again
                return
            link.setblocking(False)
            if len(self._clients) < _MOST_CLIENTS:
                self._clients.append(_Client(link))
            else:
                link.close()

    def _serve(self, client: _Client, answer: Answer) -> bool:
        """Return whether the client stays connected."""
        try:
            came = client.link.recv(_AT_ONCE)
        except BlockingIOError:
            return True
        except OSError:
            came = b""
        *lines, rest = (client.begun + came).split(b"\n")
        stays = bool(came)
        if rest and (not stays or len(rest) > LONGEST_LINE):
            # The last line before the end needs no newline. An endless line is refused.
            lines.append(rest)
            stays, rest = False, bytearray()
        client.begun = rest
        stays = self._hear(client, lines, answer) and stays
        if not stays:
            client.link.close()
        return stays

    def _hear(self, client: _Client, lines: list[bytearray], answer: Answer) -> bool:
        """Handle these lines; return whether the client stays connected."""
        for line in lines:
            if line.strip() and not self._answer(client, answer(bytes(line))):
                return False
            # A web page can make a browser send a request to this port, with lines in it.
            if b" HTTP/" in line:
                return False
        return True

    @staticmethod
    def _answer(client: _Client, text: bytes) -> bool:
        """Send the answer; return whether the client took it; one that does not read is dropped."""
        try:
            return not text or client.link.send(text) == len(text)
        except OSError:
            return False


def _tcp_door(there: Address) -> socket.socket:
    family = socket.AF_INET6 if ":" in there.host else socket.AF_INET
    door = socket.socket(family, socket.SOCK_STREAM)
    try:
        door.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        door.bind((there.host, there.port))
        door.listen()
        door.setblocking(False)
    except OSError:
        door.close()
        raise
    return door


def _unix_door(path: Path) -> socket.socket:
    """Return a socket whose file only this user can write to; replace an unused file."""
    door = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        if path.exists() and stat.S_ISSOCK(path.stat().st_mode) and not _answers(path):
            path.unlink()
        door.bind(str(path))
        path.chmod(0o600)  # nobody can connect before it listens
        door.listen()
        door.setblocking(False)
    except OSError:
        door.close()
        raise
    return door


def _answers(path: Path) -> bool:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        return probe.connect_ex(str(path)) == 0
