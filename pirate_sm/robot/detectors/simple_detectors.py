"""Detectors without dead reckoning: the simulator's own, the operator, signals; and a ruler."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from random import Random
from string import ascii_lowercase
from typing import Protocol

from pirate_sm.core.companion import CompanionBase
from pirate_sm.core.effects import Effect, Ended, Log
from pirate_sm.core.engine import EngineState, has_come
from pirate_sm.core.events import DetectorWord, Event, Look, OutsideNumber, WordWatch
from pirate_sm.core.geometry import Bend
from pirate_sm.core.models import Profile, RulerSettings
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S, Repeater, WordDetector, words_of

# --- the simulator --------------------------------------------------------------------------------


class TruePlaces(CompanionBase):
    """A companion that knows the true positions; its words have the profile's errors.

    Args:
        profile: The robot's profile, with its detector words.
        robot: The robot as the engine knows it.
        bends: The bends along the pipe.
        places_m: Returns the position of each wheel along the pipe.
        seed: Seed of the words' errors.
    """

    def __init__(
        self,
        profile: Profile,
        robot: RobotSpec,
        bends: Sequence[Bend],
        places_m: Callable[[], Sequence[float]],
        seed: int,
    ) -> None:
        self.due_s = 0.0
        self._robot = robot
        self._places_m = places_m
        words, chance = words_of(profile), Random(seed)
        errors = [chance.gauss(0.0, profile.simulation.noise.detector) for _ in words]
        self._detector = WordDetector(words, errors, bends, profile.detector.valid_for)
        self._word: DetectorWord | None = None

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Read the positions of the wheels and the direction in which they are driven."""
        travel = self._robot.travel(state.robot.values)
        self._word = self._detector.look(now_s, self._places_m(), travel)
        return ()

    def word_watch(self, state: EngineState) -> WordWatch | None:
        """Return what it knows now; None where it must look itself."""
        travel = self._robot.travel(state.robot.values)
        return self._detector.watch(self._places_m, self.due_s, travel)

    def relieve(self, looks: Sequence[Look], due_s: float, said_s: float | None) -> None:
        """Take looks that others have made; the next one is due at ``due_s``."""
        self._detector.relieve(looks, said_s)
        self.due_s = due_s

    def restart(self, robot: RobotSpec) -> None:
        """Follow this robot from now on."""
        self._robot = robot

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the word that becomes valid here, or is valid and must be repeated."""
        self.due_s = now_s + LOOK_EVERY_S
        word, self._word = self._word, None
        return () if word is None else (word,)


# --- the operator ---------------------------------------------------------------------------------


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


# --- signals --------------------------------------------------------------------------------------


class SignalWords(CompanionBase):
    """A companion that evaluates the conditions of the words at every look.

    If several hold, the last of the profile's list is reported. While a condition is unknown,
    neither its word nor an earlier one is reported, since the robot may be farther.

    Args:
        robot: The robot as the engine knows it, with the words' conditions.
        valid_for_s: How long a word is valid.
    """

    def __init__(self, robot: RobotSpec, valid_for_s: float) -> None:
        self.due_s = 0.0
        self._robot = robot
        self._since_s: dict[str, float] = {}
        self._repeater = Repeater(valid_for_s)
        self._said: tuple[Event, ...] = ()

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


# --- the ruler ------------------------------------------------------------------------------------


class Ruler(CompanionBase):
    """A companion that knows the true places and reports the noisy speed of their mean.

    Args:
        settings: Which signal it measures, how often, and how well.
        places: Returns a time in s, and where each wheel was along the pipe then, m, front to rear.
        seed: Of its errors.
    """

    def __init__(
        self,
        settings: RulerSettings,
        places: Callable[[], tuple[float, Sequence[float]]],
        seed: int,
    ) -> None:
        self.due_s = 0.0
        self._settings = settings
        self._places = places
        self._chance = Random(f"ruler {seed}")
        self._last: tuple[float, float] | None = None

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the mean speed since the last look, m/s, positive ahead."""
        self.due_s = now_s + self._settings.every
        seen_s, places_m = self._places()
        place_m = sum(places_m) / len(places_m)
        if places_m[0] < places_m[-1]:
            place_m = -place_m  # it heads against the pipe
        before, self._last = self._last, (seen_s, place_m)
        if before is None or seen_s <= before[0]:
            return ()
        speed_m_s = (place_m - before[1]) / (seen_s - before[0])
        error_m_s = self._chance.gauss(0.0, self._settings.noise)
        return (OutsideNumber(self._settings.signal, speed_m_s + error_m_s),)
