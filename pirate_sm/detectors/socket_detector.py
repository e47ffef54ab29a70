"""Makes other programs a detector: they send its words on a socket."""

from __future__ import annotations

import json
from collections.abc import Sequence
from math import inf
from typing import Self

from pirate_sm.detectors.socket_lines import LineError, read_line
from pirate_sm.detectors.socket_listener import Address, Listener
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect, Ended, Log
from pirate_sm.model.events import DetectorWord, Event

_LOOK_EVERY_S = 0.05


class OutsideWords:
    """A companion that receives words on a socket while it is entered.

    Attributes:
        listening: True until the run ends, because other programs run in real time.
    """

    def __init__(self, address: Address, words: Sequence[str], valid_for_s: float) -> None:
        self.due_s = 0.0
        self.listening = True
        self._listener = Listener(address)
        self._words = tuple(words)
        self._valid_for_s = valid_for_s
        self._received: list[DetectorWord] = []
        self._refused: list[str] = []

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
        """Read received lines; return one warning if some are not valid."""
        self._refused.clear()
        self._listener.poll(self._take)
        if not self._refused:
            return ()
        more = f" (and {len(self._refused) - 1} more)" if self._refused[1:] else ""
        return (Log("warning", f"from the detector's socket: {self._refused[0]}{more}"),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the received words, oldest first."""
        self.due_s = now_s + _LOOK_EVERY_S
        words, self._received = tuple(self._received), []
        return words

    def _take(self, line: bytes) -> bytes:
        try:
            self._received.append(read_line(line, self._words, self._valid_for_s))
        except LineError as error:
            self._refused.append(str(error))
            return json.dumps({"error": str(error)}).encode() + b"\n"
        return b""
