"""Makes other programs a detector: they send its words, and numbers, as lines of JSON on a socket.

Several programs may write; reading never blocks. Over TCP a program must know a token, since every
user of the machine can connect. A Unix socket needs none: its file belongs to the user of the run.
"""

from __future__ import annotations

import errno
import json
import os
import re
import socket
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from hmac import compare_digest
from ipaddress import ip_address
from math import inf, nan
from pathlib import Path
from typing import Self

from pirate_sm.core.effects import Effect, Ended, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import DetectorWord, Event, OutsideNumber
from pirate_sm.core.spelling import meant, one_of
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S

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


LONGEST_LINE = 4096
"""Bytes; valid lines are far shorter."""

LONGEST_VALIDITY_S = 60.0
"""The longest validity, because a program may have died after its word."""

_SHOWN = 60
_LARGEST = 1e300


class LineError(ValueError):
    """Is raised for a line that is not valid; its text is for the sender."""


@dataclass(frozen=True)
class AcceptedLines:
    """What other programs may send.

    Attributes:
        words: The words in the robot's profile; empty where words come from elsewhere.
        valid_for_s: Validity of a word for a line that has none.
        signals: The outside signals of the robot, with the validity of each.
    """

    words: Sequence[str]
    valid_for_s: float = LONGEST_VALIDITY_S
    signals: Mapping[str, float] = field(default_factory=dict)

    @property
    def example(self) -> str:
        """Return a line that is valid."""
        if self.words:
            return f'{{"word": "{self.words[0]}"}}'
        return f'{{"signal": "{next(iter(self.signals), "NAME")}", "value": 0.1}}'


def read_line(line: bytes, accepted: AcceptedLines) -> DetectorWord | OutsideNumber:
    """Return the word or number in a line.

    Args:
        line: ``{"word": "...", "valid_for_s": 1.0, "age_s": 0.1}`` or ``{"signal": "...",
            "value": 0.1, "age_s": 0.1}`` in UTF-8; ``valid_for_s`` and ``age_s`` may be left out.
            ``age_s`` is taken off the validity.
        accepted: What the robot knows.

    Raises:
        LineError: The line is not valid, has an unknown name, or is older than its validity.
    """
    said = read_object(line, accepted.example)
    fields = ("signal", "value") if "signal" in said else ("word", "valid_for_s")
    unknown = [key for key in said if key not in (*fields, "age_s")]
    if unknown:
        raise LineError(f"unknown field '{_short(unknown[0].encode(errors='replace'))}'")
    if "signal" in said:
        name = _name(said, "signal", tuple(accepted.signals))
        return OutsideNumber(name, _value(said), _age(said, accepted.signals[name]))
    word = _name(said, "word", accepted.words)
    valid_for_s = _seconds(said, "valid_for_s", accepted.valid_for_s)
    if not 0 < valid_for_s <= LONGEST_VALIDITY_S:
        raise LineError(f"'valid_for_s' is more than 0 and at most {LONGEST_VALIDITY_S:g} seconds")
    return DetectorWord(word, valid_for_s - _age(said, valid_for_s))


def read_object(line: bytes, example: str) -> dict[str, object]:
    """Return the JSON object in a line.

    Raises:
        LineError: It is not a JSON object, or too long.
    """
    if len(line) > LONGEST_LINE:
        raise LineError(f"a line has at most {LONGEST_LINE} bytes")
    try:
        said = json.loads(line, parse_int=float)
    except (ValueError, RecursionError):
        raise LineError(f"not a line of JSON in UTF-8: {_short(line)}") from None
    if not isinstance(said, dict):
        raise LineError(f"expected an object such as {example}")
    return said


def _name(said: dict[str, object], key: str, names: Sequence[str]) -> str:
    name = said.get(key)
    if not names:
        raise LineError(f"no {key} is accepted here")
    if not isinstance(name, str):
        raise LineError(f"'{key}' is a text, {one_of(names)}")
    if name not in names:
        shown = _short(name.encode(errors="replace"))
        raise LineError(f"unknown {key} '{shown}': {meant(name, names)}")
    return name


def _value(said: dict[str, object]) -> float:
    """Return the number measured, in SI; null is unknown."""
    value = said.get("value")
    if value is None and "value" in said:
        return nan
    if not isinstance(value, float):
        raise LineError("'value' is a number in SI units, or null where it is unknown")
    if not abs(value) < _LARGEST:  # as for NaN
        raise LineError("'value' is a finite number")
    return value


def _age(said: dict[str, object], valid_for_s: float) -> float:
    age_s = _seconds(said, "age_s", 0.0)
    if not 0 <= age_s < valid_for_s:
        raise LineError(f"'age_s' is at least 0 and less than the validity, {valid_for_s:g} s")
    return age_s


def _seconds(said: dict[str, object], key: str, default: float) -> float:
    value = said.get(key, default)
    if not isinstance(value, float):
        raise LineError(f"'{key}' is a number of seconds")
    return value


def _short(line: bytes) -> str:
    text = " ".join(line.decode(errors="replace").split())
    shown = "".join(letter if letter.isprintable() else "�" for letter in text)
    return shown if len(shown) <= _SHOWN else f"{shown[: _SHOWN - 1]}…"


# --- connected programs ---------------------------------------------------------------------------

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


_WARN_EVERY_S = 1.0


class OutsideWords:
    """A companion that receives words and numbers on a socket while it is entered.

    Args:
        address: Where programs connect.
        accepted: What they may send.
        token: What they must give first; empty for nothing.

    Attributes:
        listening: True until the run ends, because other programs run in real time.
    """

    def __init__(self, address: Address, accepted: AcceptedLines, token: str = "") -> None:
        self.due_s = 0.0
        self.listening = True
        self._listener = Listener(address, token)
        self._accepted = accepted
        self._received: list[Event] = []
        self._refused = 0
        self._quiet_until_s = -inf

    @property
    def address(self) -> Address:
        """The address that programs connect to."""
        return self._listener.address

    def __enter__(self) -> Self:
        """Open the socket."""
        self._listener.open()
        return self

    def __exit__(self, *_: object) -> None:
        """Close the socket."""
        self._listener.close()

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Stop listening at the end of the run."""
        if any(isinstance(effect, Ended) for effect in effects):
            self.due_s, self.listening = inf, False

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Read received lines; return a warning, at most one a second, if some are not valid."""
        refused = self._listener.poll(self._take)
        self._refused += len(refused)
        if not refused or now_s < self._quiet_until_s:
            return ()
        more = f" (and {self._refused - 1} more)" if self._refused > 1 else ""
        self._refused, self._quiet_until_s = 0, now_s + _WARN_EVERY_S
        return (Log("warning", f"from the detector's socket: {refused[0]}{more}"),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return what was received, oldest first."""
        self.due_s = now_s + LOOK_EVERY_S
        received, self._received = tuple(self._received), []
        return received

    def _take(self, line: bytes) -> None:
        self._received.append(read_line(line, self._accepted))
