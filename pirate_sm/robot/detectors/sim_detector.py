"""The simulator's own detector: reports the profile's words by the true positions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random

from pirate_sm.core.effects import Effect, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import DetectorWord, Event, Look, WordWatch
from pirate_sm.core.geometry import Bend
from pirate_sm.core.profile import Profile
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S, WordDetector, words_of


class TruePlaces:
    """A companion that knows the true positions; its words have the profile's errors.

    Args:
        profile: The robot's profile, with its detector words.
        robot: The robot as the engine knows it.
        bends: The bends along the pipe.
        places_m: Returns the position of each wheel along the pipe.
        seed: Seed of the words' errors.
    """

    listening = False

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

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing."""

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
