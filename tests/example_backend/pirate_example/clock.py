"""A detector that says the robot's words one after the other, at equal times."""

from __future__ import annotations

from collections.abc import Sequence

from pirate_sm import UsageError
from pirate_sm.plugins import Asked, Detecting, DetectorWord, Effect, Event, MakeDetector, Plugin


class Clock:
    """A companion that says a word every so many seconds."""

    listening = False

    def __init__(self, every_s: float, words: Sequence[str], valid_for_s: float) -> None:
        self.due_s = every_s
        self._every_s = every_s
        self._words = tuple(words)
        self._valid_for_s = valid_for_s
        self._said = 0

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing: time alone counts."""

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the next word."""
        self.due_s = now_s + self._every_s
        word = self._words[self._said % len(self._words)]
        self._said += 1
        return (DetectorWord(word, self._valid_for_s),)


def make(asked: Asked) -> Detecting:
    """Return the detector for ``clock:SECONDS``."""
    try:
        every_s = float(asked.argument or "")
    except ValueError:
        raise UsageError("expected clock:SECONDS") from None
    words, valid_for_s = asked.robot.detector_words, asked.profile.detector.valid_for
    notice = f"detector: a word every {every_s:g} s"
    return Detecting("clock", (Clock(every_s, words, valid_for_s),), (notice,))


DETECTOR: Plugin[MakeDetector] = Plugin("a word every so many seconds: clock:SECONDS", make)
