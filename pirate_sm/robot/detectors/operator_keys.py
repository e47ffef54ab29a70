"""Makes the operator a detector: one key for each word."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from string import ascii_lowercase
from typing import Protocol

from pirate_sm.core.effects import Effect, Ended
from pirate_sm.core.events import DetectorWord, Event
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S

LETTERS = ascii_lowercase
"""The keys, in order; digits answer questions."""


def offer(words: Sequence[str]) -> str:
    """Return the keys and their words, as text for people."""
    return "  ".join(f"[{key}] {word}" for key, word in _keys_of(words).items())


def _keys_of(words: Sequence[str]) -> dict[str, str]:
    return dict(zip(LETTERS, words, strict=False))


class Keys(Protocol):
    """Returns the keys pressed since the last call."""

    def pressed(self) -> str:
        """Return the keys, oldest first; empty if there were none."""


class WordKeys:
    """A companion with a key for each word; each press makes its word valid for a time.

    Attributes:
        listening: True until the run ends, because a person is watching the robot.
        offered: The keys and their words, as text for people.
    """

    def __init__(self, keys: Keys, words: Sequence[str], valid_for_s: float) -> None:
        self.due_s = 0.0
        self.listening = True
        self._keys = keys
        self._words = _keys_of(words)
        self._valid_for_s = valid_for_s
        self.offered = offer(words)

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Stop listening at the end of the run."""
        if any(isinstance(effect, Ended) for effect in effects):
            self.due_s, self.listening = inf, False

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the words of the pressed keys, oldest first."""
        self.due_s = now_s + LOOK_EVERY_S
        said = (self._words.get(key.lower()) for key in self._keys.pressed())
        return tuple(DetectorWord(word, self._valid_for_s) for word in said if word)
