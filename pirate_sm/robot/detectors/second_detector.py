"""A second detector next to the one in force: its words are logged, and never reach the mission."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from math import inf
from typing import Self

from pirate_sm.core.companion import Companion, Counting, Onlooker, entered
from pirate_sm.core.effects import Effect, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import DetectorWord, Event, FaultReport
from pirate_sm.core.robot import RobotSpec


class SecondDetector:
    """A companion that logs what another detector would report; a repeated word is logged once.

    Args:
        name: The detector's name.
        companion: A companion of the detector.
    """

    def __init__(self, name: str, companion: Companion) -> None:
        self._name = name
        self._companion = companion
        self._until_s: dict[str, float] = {}
        self._entered = ExitStack()

    @property
    def due_s(self) -> float:
        """Return the mission time of its next call."""
        return self._companion.due_s

    @property
    def listening(self) -> bool:
        """Return whether the detector waits for a person or another program."""
        return self._companion.listening

    def __enter__(self) -> Self:
        """Open the detector."""
        self._entered.enter_context(entered([self._companion]))
        return self

    def __exit__(self, *_: object) -> None:
        """Close the detector."""
        self._entered.close()

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Process the effects of the last step."""
        self._companion.react(effects, now_s)

    def restart(self, robot: RobotSpec) -> None:
        """Begin again for another mission."""
        if isinstance(self._companion, Counting):
            self._companion.restart(robot)

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return the detector's own messages, and its words and faults since the last look."""
        looked = self._companion.look(state, now_s) if isinstance(self._companion, Onlooker) else ()
        return (*looked, *self._logs(self._companion.speak(now_s), now_s))

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return nothing: the detector has been asked in ``look``."""
        return ()

    def _logs(self, events: Sequence[Event], now_s: float) -> Iterator[Log]:
        """Yield a message for each fault, and for a word that is not valid already."""
        for event in events:
            if isinstance(event, FaultReport):
                yield Log("warning", f"also {self._name}: {event.message}")
            elif isinstance(event, DetectorWord):
                if now_s > self._until_s.get(event.word, -inf):
                    yield Log("info", f"also {self._name}: {event.word}")
                self._until_s = {event.word: now_s + event.valid_for_s}
