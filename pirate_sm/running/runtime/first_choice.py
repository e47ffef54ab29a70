"""Answers every question of a mission with its first choice."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import Literal

from pirate_sm.core.effects import Ask, Effect, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Answer, Event


class Answered(Log):
    """A question was answered automatically; the message has the answer and the reason."""

    __slots__ = ()


class FirstChoice:
    """Answers every question at once with the expected answer, because nobody can be asked.

    Args:
        why: Why nobody can be asked, for a log line with each answer. Empty: no log lines.
        level: Level of the log lines.
    """

    listening = False

    def __init__(self, why: str = "", level: Literal["info", "warning"] = "info") -> None:
        self._why = why
        self._level = level
        self.due_s = inf
        self._choice = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Prepare the first choice of a question; drop that of a withdrawn question."""
        for effect in effects:
            if isinstance(effect, Ask):
                asked = bool(effect.question and effect.choices)
                self._choice = effect.choices[0] if asked else ""
                self.due_s = now_s if asked else inf

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return a log line with the coming answer."""
        if not self._why:
            return ()
        return (Answered(self._level, f"answered '{self._choice}' ({self._why})"),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the answer."""
        self.due_s = inf
        return (Answer(self._choice),)
