"""A local socket on which several programs write lines; reading never blocks.

Over TCP a program must know a token, since every user of the machine can connect. A Unix socket
needs none: its file belongs to the user of the run.
"""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from hmac import compare_digest
from pathlib import Path

from pirate_sm.robot.detectors.socket_address import Address, open_socket
from pirate_sm.robot.detectors.socket_lines import LONGEST_LINE, LineError, read_object

_MOST_CLIENTS = 16
_MOST_AT_ONCE = 32
"""Connections that are accepted in one turn; the others wait for the next turn."""
_AT_ONCE = LONGEST_LINE
"""Bytes that are read from one client in one turn, so that no client holds up the run."""
_FULL_TURNS = 10
"""A client that fills this number of turns without a break sends faster than it can be read."""
_TURNS_FOR_TOKEN = 40
"""Turns that a client has for its token: 2 s where the socket is read every 50 ms."""

Take = Callable[[bytes], None]
"""Takes a line; raises :class:`LineError` for one that is not valid."""


@dataclass
class _Client:
    """A program that is connected.

    Attributes:
        trusted: Whether it has given the token, or none is needed.
        begun: The line that has no end yet.
        turns: How often it has been read.
        full_turns: How often without a break it has sent all that is read in one turn.
    """

    link: socket.socket
    trusted: bool = False
    begun: bytearray = field(default_factory=bytearray)
    turns: int = 0
    full_turns: int = 0


class Listener:
    """Listens between ``open`` and ``close``.

    Args:
        address: Where it listens.
        token: What a program must give in its first line, ``{"token": "…"}``; empty for nothing.

    Attributes:
        address: The address; once open, with the assigned port instead of 0.
    """

    def __init__(self, address: Address, token: str = "") -> None:
        self.address = address
        self._token = token
        self._listening: socket.socket | None = None
        self._clients: list[_Client] = []
        self._refused: list[str] = []

    def open(self) -> None:
        """Open the socket.

        Raises:
            UsageError: The address cannot be used.
        """
        self._listening, self.address = open_socket(self.address)

    def close(self) -> None:
        """Disconnect all programs and remove the socket's file; may be called twice."""
        for client in self._clients:
            client.link.close()
        self._clients.clear()
        if self._listening is None:
            return
        self._listening.close()
        self._listening = None
        if self.address.path:
            with suppress(OSError):
                Path(self.address.path).unlink()

    def poll(self, take: Take) -> list[str]:
        """Give every complete line to ``take``; return why lines were refused.

        A refused line is answered with ``{"error": "…"}``. Each client is read once, in the order
        of their connections; it returns at once if there is nothing to read.
        """
        self._refused = []
        self._let_in()
        for client in tuple(self._clients):
            if not self._serve(client, take):
                self._drop(client)
        return self._refused

    def _let_in(self) -> None:
        for _ in range(_MOST_AT_ONCE):
            if self._listening is None:
                return
            try:
                link, _ = self._listening.accept()
            except OSError:  # no client, or one that has gone again
                return
            link.setblocking(False)
            if len(self._clients) >= _MOST_CLIENTS:
                self._make_room()
            if len(self._clients) < _MOST_CLIENTS:
                self._clients.append(_Client(link, trusted=not self._token))
            else:
                self._refuse(_Client(link), f"{_MOST_CLIENTS} programs are connected already")
                link.close()

    def _make_room(self) -> None:
        """Drop the oldest client that has not given the token, if there is one."""
        for client in self._clients:
            if not client.trusted:
                self._drop(client)
                return

    def _drop(self, client: _Client) -> None:
        client.link.close()
        self._clients.remove(client)

    def _serve(self, client: _Client, take: Take) -> bool:
        """Return whether the client stays connected."""
        client.turns += 1
        try:
            came = client.link.recv(_AT_ONCE)
        except BlockingIOError:
            client.full_turns = 0
            return client.trusted or client.turns < _TURNS_FOR_TOKEN
        except OSError:
            came = b""
        client.full_turns = client.full_turns + 1 if len(came) == _AT_ONCE else 0
        *lines, rest = (client.begun + came).split(b"\n")
        stays = bool(came)
        if not stays or len(rest) > LONGEST_LINE:
            # The last line before the end needs no newline. An endless line is refused.
            lines.append(rest)
            stays, rest = False, bytearray()
        client.begun = rest
        if client.full_turns > _FULL_TURNS:
            self._refuse(client, "too many lines: what is read late is no longer true")
            return False
        return self._read(client, lines, take) and stays

    def _read(self, client: _Client, lines: Iterable[bytearray], take: Take) -> bool:
        """Take these lines; return whether the client stays connected."""
        for line in lines:
            # A web page can make a browser send a request to this port, with lines in it.
            if b" HTTP/" in line:
                self._refuse(client, "this is not a web server")
                return False
            if not line.strip():
                continue
            try:
                if client.trusted:
                    take(bytes(line))
                else:
                    self._check(client, bytes(line))
            except LineError as error:
                if not self._refuse(client, str(error)) or not client.trusted:
                    return False
        return True

    def _check(self, client: _Client, line: bytes) -> None:
        """Trust the client if the line holds the token.

        Raises:
            LineError: It does not.
        """
        form = '{"token": "…"}'
        given = read_object(line, form).get("token")
        if not isinstance(given, str):
            raise LineError(f"the first line is {form}, with the token that the run shows")
        if not compare_digest(given.encode(errors="replace"), self._token.encode()):
            raise LineError("this is not the token of this run")
        client.trusted = True

    def _refuse(self, client: _Client, why: str) -> bool:
        """Answer with an error; return whether the client took it: one that does not is dropped."""
        self._refused.append(why)
        answer = json.dumps({"error": why}).encode() + b"\n"
        try:
            return client.link.send(answer) == len(answer)
        except OSError:
            return False
