"""Makes other programs a detector: they send its words, and numbers, on a socket."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import Self

from pirate_sm.core.effects import Effect, Ended, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event
from pirate_sm.robot.detectors.socket_address import Address
from pirate_sm.robot.detectors.socket_lines import AcceptedLines, read_line
from pirate_sm.robot.detectors.socket_listener import Listener
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S

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
