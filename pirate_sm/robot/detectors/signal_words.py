"""The detector ``signals``: reports each word whose condition on the robot's signals holds."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from pirate_sm.core.effects import Effect, Log
from pirate_sm.core.engine import EngineState, has_come
from pirate_sm.core.events import Event
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S, Repeater


class SignalWords:
    """A companion that evaluates the conditions of the words at every look.

    If several hold, the last of the profile's list is reported. While a condition is unknown,
    neither its word nor an earlier one is reported, since the robot may be farther.

    Args:
        robot: The robot as the engine knows it, with the words' conditions.
        valid_for_s: How long a word is valid.
    """

    listening = False

    def __init__(self, robot: RobotSpec, valid_for_s: float) -> None:
        self.due_s = 0.0
        self._robot = robot
        self._since_s: dict[str, float] = {}
        self._repeater = Repeater(valid_for_s)
        self._said: tuple[Event, ...] = ()

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Evaluate the conditions."""
        word = self._repeater.say(self._holding(state, now_s), now_s)
        self._said = () if word is None else (word,)
        return ()

    def restart(self, robot: RobotSpec) -> None:
        """Follow this robot from now on."""
        self._robot = robot

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the word that becomes valid here, or is valid and must be repeated."""
        self.due_s = now_s + LOOK_EVERY_S
        said, self._said = self._said, ()
        return said

    def _holding(self, state: EngineState, now_s: float) -> str:
        """Return the word to report; empty for none."""
        numbers, words = state.sensing.numbers, state.obeyed_words(self._robot)
        holding, unknown = "", False
        for each in reversed(self._robot.word_conditions):
            value = each.when.evaluate(numbers, words)
            since_s = self._since_s.get(each.word, inf)
            self._since_s[each.word] = min(since_s, now_s) if value is True else inf
            if holding or unknown:
                continue
            if value is None:
                unknown = True
            elif has_come(now_s, self._since_s[each.word] + each.held_s):
                holding = each.word
        return holding
