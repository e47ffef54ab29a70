"""The simulator's own detector: says the profile's words where the wheels really are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random

from pirate_sm.detectors.odometry_detector import LOOK_EVERY_S
from pirate_sm.detectors.word_timing import Detector, words_of
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect, Log
from pirate_sm.model.events import DetectorWord, Event
from pirate_sm.model.profile import Profile


class TruePlaces:
    """A companion that knows the true places; its words are off by the profile's noise.

    Args:
        profile: The robot with its detector's words.
        robot: The same, as the engine knows it.
        crossings_m: Where the bends of the pipe are, along the pipe.
        places_m: Returns where each wheel is along the pipe.
        seed: Of the words' errors.
    """

    listening = False

    def __init__(
        self,
        profile: Profile,
        robot: RobotSpec,
        crossings_m: Sequence[float],
        places_m: Callable[[], Sequence[float]],
        seed: int,
    ) -> None:
        self.due_s = 0.0
        self._robot = robot
        self._places_m = places_m
        words, chance = words_of(profile), Random(seed)
        errors = [chance.gauss(0.0, profile.simulation.noise.detector) for _ in words]
        self._detector = Detector(words, errors, crossings_m, profile.detector.valid_for)
        self._word: DetectorWord | None = None

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing: what counts is where the robot is."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Look where the wheels are and which way they are driven."""
        travel = self._robot.travel(state.robot.values)
        self._word = self._detector.look(now_s, self._places_m(), travel)
        return ()

    def restart(self, robot: RobotSpec) -> None:
        """Follow this robot from now on."""
        self._robot = robot

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the word that begins to hold here, or still holds and must be said again."""
        self.due_s = now_s + LOOK_EVERY_S
        word, self._word = self._word, None
        return () if word is None else (word,)
