"""What a recording shows of a robot without its mission: signals, states and surroundings.

Signals follow from the frames of its boards. States, and what is confirmed of them, are taken from
the effects of the run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    Flight,
    Mark,
    RobotState,
    confirmed_parts,
)
from pirate_sm.core._engine.safety import no_faults
from pirate_sm.core._engine.sensing.environment import Surveyed, survey
from pirate_sm.core._engine.sensing.known_signals import nothing_known
from pirate_sm.core._engine.sensing.signal_table import forget_stale, observe
from pirate_sm.core._engine.state import EngineState, MissionState
from pirate_sm.core._model.events import DetectorWord, Event, SensorFrame, SubmitResult
from pirate_sm.core.effects import Effect, Environment, Setpoints, StateChange

Wheels: TypeAlias = tuple[int, ...]


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

    def travelled(
        self, odometer: Callable[[EngineState, float, Wheels], float], wheels: Wheels
    ) -> float:
        """Return what an odometer has counted until now, m."""
        return odometer(self.state, self.at_s, wheels)


class RobotListener:
    """Follows a robot through a recording.

    Args:
        robot: The robot.
    """

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

    def hear(self, event: Event | None, effects: Iterable[Effect], now_s: float) -> RobotLook:
        """Return what is known after a step.

        Args:
            event: The event of the step; None if it had none.
            effects: Its effects.
            now_s: Its time since the run began.
        """
        match event:
            case SensorFrame() as frame:
                self._sense(frame, now_s)
            case DetectorWord(word=word, valid_for_s=valid_for_s):
                self._word, self._until_s = word, now_s + valid_for_s
            case SubmitResult(setpoint_id=number, status="accepted") if number in self._sent:
                body = self._state.robot._replace(values=self._sent[number], flight=None)
                self._state = self._state._replace(robot=body)
            case _:
                pass
        for effect in effects:
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
