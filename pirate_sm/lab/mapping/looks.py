"""Looks at a recorded robot: what is known of it at each step, without mission, pipe and truth.

Of a recording only these are read: the robot's own files, the frames of its boards, the detector's
words, and what it was commanded to: its states and its setpoints.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from typing import NamedTuple

from pirate_sm.core.effects import Environment, Setpoints, StateChange
from pirate_sm.core.engine import EngineState, MissionState
from pirate_sm.core.events import DetectorWord, SensorFrame, SubmitResult
from pirate_sm.core.robot import Flight, Mark, RobotSpec, RobotState, confirmed_parts, no_faults
from pirate_sm.core.sensing import Surveyed, forget_stale, nothing_known, observe, survey
from pirate_sm.robot.detectors.odometry import Odometer
from pirate_sm.robot.detectors.word_timing import Word
from pirate_sm.running.recording.read.pieces import RecordedStep


class RobotLook(NamedTuple):
    """What is known of the robot at one time.

    Attributes:
        at_s: The time since the run began.
        numbers: Every signal in SI; NaN is unknown.
        held: The parts whose clamp is confirmed.
        driven: Whether a wheel is driven by the setpoints in force.
        around: The pipe around the robot, as its signals and words show it.
        part: The clamped part in whose plane roll and pitch are; -1 without one.
        announced: The kind of joint that the valid word announces; empty without one.
        word: The detector's word that is valid; empty without one.
        travel: Where wheels were driven last: 1 forward, -1 backward, 0 nowhere yet.
        state: The state by which an odometer counts.
    """

    at_s: float
    numbers: tuple[float, ...]
    held: frozenset[int]
    driven: bool
    around: Environment
    part: int
    announced: str
    word: str
    travel: int
    state: EngineState

    def travelled(self, odometer: Odometer, wheels: Iterable[int]) -> float:
        """Return what an odometer has counted until now, m."""
        return odometer.look(self.state, self.at_s, tuple(wheels))


def looks(
    robot: RobotSpec, steps: Iterable[RecordedStep], origin_s: float = 0.0
) -> Iterator[RobotLook]:
    """Yield what is known of the robot after each step that reports on it or commands it.

    Args:
        robot: The robot.
        steps: The steps of the recording.
        origin_s: When the run began, by the engine's clock.
    """
    listener = _Listener(robot)
    for step in steps:
        heard = isinstance(step.event, SensorFrame | DetectorWord | SubmitResult)
        if heard or any(isinstance(each, StateChange | Setpoints) for each in step.effects):
            yield listener.hear(step, step.at_s - origin_s)


class _Listener:
    def __init__(self, robot: RobotSpec) -> None:
        values = (0.0,) * len(robot.slots)
        self._robot = robot
        self._indexes = {states: n for n, states in enumerate(robot.table.configurations)}
        self._state = EngineState(
            RobotState(robot.table.initial, values),
            nothing_known(robot),
            MissionState(0),
            no_faults(robot),
            (None,) * len(robot.vocabulary.words),
        )
        self._surveyed = Surveyed()
        self._around: Environment = self._surveyed.reported
        self._word: str | None = None
        self._until_s = 0.0
        self._travel = 0
        self._sent: dict[int, tuple[float, ...]] = {}

    def hear(self, step: RecordedStep, now_s: float) -> RobotLook:
        """Return what is known after a step."""
        match step.event:
            case SensorFrame() as frame:
                self._sense(frame, now_s)
            case DetectorWord(word=word, valid_for_s=valid_for_s):
                self._word, self._until_s = word, now_s + valid_for_s
            case SubmitResult(setpoint_id=number, status="accepted") if number in self._sent:
                body = self._state.robot._replace(values=self._sent[number], flight=None)
                self._state = self._state._replace(robot=body)
            case _:
                pass
        for effect in step.effects:
            if isinstance(effect, StateChange):
                self._become(effect)
            elif isinstance(effect, Setpoints):
                self._sent[effect.setpoint_id] = effect.values
                flight = Flight(effect.setpoint_id, effect.values, "gate")
                body = self._state.robot._replace(flight=flight, sent=True)
                self._state = self._state._replace(robot=body)
        return self._look(now_s)

    def _sense(self, frame: SensorFrame, now_s: float) -> None:
        body = self._state.robot
        sensing, _ = observe(
            self._robot, self._state.sensing, frame, body.values, body.latest, now_s, sent=body.sent
        )
        sensing = forget_stale(self._robot, sensing, now_s)
        self._state = self._state._replace(sensing=sensing)

    def _become(self, change: StateChange) -> None:
        """Take a new configuration.

        A part whose region is not confirmed still holds if it has held before; if only its
        confirmation is new, a fault has denied it.
        """
        robot, before = self._robot, self._state.robot
        here = self._indexes[tuple(change.states)]
        regions = {robot.regions.index(name) for name in change.unconfirmed}
        lasting = confirmed_parts(robot, before) if here != before.configuration else frozenset()
        marks = frozenset(
            Mark("part", part, 0)
            for part, depends in enumerate(robot.part_regions)
            if depends & regions and part not in lasting
        )
        body = before._replace(configuration=here, marks=marks)
        self._state = self._state._replace(robot=body)

    def _look(self, now_s: float) -> RobotLook:
        robot, state = self._robot, self._state
        word = self._word if now_s < self._until_s else None
        if now_s >= self._surveyed.due_s:
            self._surveyed, self._around = survey(
                *(robot, self._surveyed, state.robot, state.sensing.numbers),
                *(word, frozenset(), now_s),
            )
        driven = any(state.robot.values[wheel.slot] for wheel in robot.wheels)
        self._travel = robot.travel(state.robot.values) or self._travel
        return RobotLook(
            now_s,
            state.sensing.numbers,
            confirmed_parts(robot, state.robot),
            driven,
            self._around,
            self._surveyed.part,
            robot.words_joint.get(word or "", ""),
            word or "",
            self._travel,
            state,
        )


# --- places of words -----------------------------------------------------------------------------
# A word begins when its wheel passes a point: a distance from where the axes meet, or, at an
# elbow, from where they would meet in a mitre that takes as much wall as its beginning or its end.
# The first word of a joint counts from its beginning, the others from its end.


_SURELY_M = 0.02
"""When the direction changes, a detector repeats its word; words count after this distance
[decided]."""


class JointEnd(Enum):
    """Which end of a joint a word counts from, and whether the whole robot is behind it."""

    BEGINS = "begins"
    INSIDE = "inside"
    PASSED = "passed"


class WordPlace(NamedTuple):
    """A word that has just begun.

    Attributes:
        end: What it counts from.
        wheel: The wheel that has reached its point.
        passed_m: How far that is behind the end, in the direction of travel.
        leads: The direction of travel: 1 forward, -1 backward.
    """

    end: JointEnd
    wheel: int
    passed_m: float
    leads: int


class WordReader:
    """Notes where words begin.

    Args:
        words: The detector's words that have points, in the order in which a robot reaches them.
    """

    def __init__(self, words: Sequence[Word]) -> None:
        self._words = {word.name: word for word in words}
        self._names = [word.name for word in words]
        self._before = ""
        self._travel = 0
        self._since_m = 0.0

    def look(self, look: RobotLook, way_m: float) -> WordPlace | None:
        """Return the word that has begun with this look.

        Args:
            look: What is known of the robot.
            way_m: How far it has travelled.
        """
        if look.travel != self._travel:
            self._travel, self._since_m, self._before = look.travel, way_m, ""
        if look.word and look.word not in self._words:
            return None
        before, self._before = self._before, look.word
        if look.word in ("", before):
            return None
        number = self._names.index(look.word)
        if before and self._names.index(before) > number:
            return None
        surely = look.driven and abs(way_m - self._since_m) >= _SURELY_M
        if not before and not surely:
            return None
        word = self._words[look.word]
        point = word.forward if look.travel > 0 else word.backward
        ends = {0: JointEnd.BEGINS, len(self._names) - 1: JointEnd.PASSED}
        end = ends.get(number, JointEnd.INSIDE)
        return WordPlace(end, point.wheel, point.passed_m, look.travel)
