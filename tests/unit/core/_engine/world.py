"""Random event sequences for the engine, and what must hold after every single one of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from driving import joints_that_obey
from hypothesis import strategies as st

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import confirmed_parts
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._model import events as ev

ROUNDING_S = 1e-6
MOST_TICKS_IN_A_MOMENT = 20

_CHOICE = st.integers(0, 10_000)
"""Picks one of however many there are when it is used."""

ACTIONS = st.one_of(
    # The world does what it is told, so that missions get somewhere.
    st.tuples(st.just("obey"), st.sampled_from([0.05, 0.2, 0.5, 2.0]), _CHOICE),
    st.tuples(st.just("obey"), st.sampled_from([0.05, 0.2, 0.5, 2.0]), _CHOICE),
    st.tuples(st.just("wake"), st.just(0.0), _CHOICE),
    st.tuples(
        st.sampled_from(["accepted", "accepted", "unknown", "rejected", "superseded"]),
        st.sampled_from([0.0, 0.05]),
        _CHOICE,
    ),
    st.tuples(
        st.sampled_from(
            [
                *("frame", "blind", "short", "stranger", "word", "environment", "stray"),
                *("fault", "command", "answer", "pause", "resume", "step", "skip"),
            ]
        ),
        st.sampled_from([0.0, 0.0, 0.1, 0.7, 3.0]),
        _CHOICE,
    ),
    st.tuples(st.sampled_from(["abort", "wait", "pause", "resume"]), st.just(30.0), _CHOICE),
)
COURSES = st.lists(ACTIONS, max_size=60)

Action = tuple[str, float, int]


@dataclass
class Course:
    """A run whose events are made from actions; checks everything after each event.

    Attributes:
        given: The events with their times, to be replayed.
    """

    robot: RobotSpec
    program: Program
    nominal: bool
    now: float = 0.0
    given: list[tuple[float, ev.Event]] = field(default_factory=list)
    effects: list[fx.Effect] = field(default_factory=list)
    signals: dict[str, float] = field(default_factory=dict)
    question: tuple[str, ...] = ()
    waiting_for: tuple[str, ...] = ()
    sent: fx.Setpoints | None = None
    accepted: fx.Setpoints | None = None
    unresolved: bool = False
    streamed: bool = False
    active: str = ""
    commanded_in_pause: bool = False

    def __post_init__(self) -> None:
        self.engine = Engine(self.robot, self.program, nominal=self.nominal)
        self.state, effects = self.engine.start(0.0)
        self._check(None, self.state, effects)

    @property
    def ended(self) -> bool:
        return self.state.mission.ended

    def run(self, course: list[Action]) -> None:
        for action, wait, choice in course:
            if self.ended:
                break
            self.act(action, wait, choice)
        self.finish()

    def finish(self) -> None:
        """The run is aborted, and ends although nothing answers any more."""
        if not self.ended:
            self.give(ev.Abort("end of the test"))
        for _ in range(2000):
            if self.ended:
                break
            assert math.isfinite(self.state.wake_at_s), "it would never end"
            self.give(ev.Tick(), max(self.now, self.state.wake_at_s))
        assert self.ended

    # --- making events ---

    def act(self, action: str, wait: float, choice: int) -> None:
        if action == "obey":
            self._obey(self.now + wait)
        elif action == "wake":
            if math.isfinite(self.state.wake_at_s):
                self.give(ev.Tick(), max(self.now, self.state.wake_at_s))
        elif action in ("accepted", "unknown", "rejected", "superseded"):
            self._resolve(action, self.now + wait)
        else:
            self.give(self._event(action, choice), self.now + wait)

    def _event(self, action: str, choice: int) -> ev.Event:
        event = self._of_the_robot(action, choice) or self._of_the_operator(action, choice)
        if action == "abort" and choice % 4 == 0:
            return ev.Abort("by the test")
        return event or ev.Tick()

    def _of_the_robot(self, action: str, choice: int) -> ev.Event | None:
        boards = list(self.robot.boards)
        board = boards[choice % len(boards)]
        words = (*self.robot.detector_words, "nonsense")
        codes = (*self.robot.fault_codes, "made.up")
        noise = tuple(float((choice * (7 + i)) % 4096 - 2048) for i in range(9))
        makers: dict[str, ev.Event] = {
            "frame": ev.SensorFrame(board, noise),
            "blind": ev.SensorFrame(board, (math.nan,) * 9),
            "short": ev.SensorFrame(board, (1.0,) * (choice % 3)),
            "stranger": ev.SensorFrame(99, (1.0,) * 9),
            "word": ev.DetectorWord(words[choice % len(words)], 0.5 + choice % 3),
            "environment": ev.EnvironmentReport("Joint", 0.1, 0.2, 0.12),
            "stray": ev.SubmitResult(choice % 50, "accepted"),
            "fault": ev.FaultReport(codes[choice % len(codes)], "it was said"),
        }
        return makers.get(action)

    def _of_the_operator(self, action: str, choice: int) -> ev.Event | None:
        commands = (*self.robot.table.commands, "Nonsense")
        answers = (*self.question, "nonsense")
        triggers = ("", *self.waiting_for, "nonsense")
        makers: dict[str, ev.Event] = {
            "command": ev.OperatorCommand(commands[choice % len(commands)]),
            "answer": ev.Answer(answers[choice % len(answers)]),
            "skip": ev.Skip(triggers[choice % len(triggers)]),
            "pause": ev.Pause(),
            "resume": ev.Resume(),
            "step": ev.Step(),
        }
        return makers.get(action)

    def _obey(self, until: float) -> None:
        """What was sent is accepted, and the robot does it: all sensors tell so."""
        self._resolve("accepted", self.now)
        if self.ended:
            return
        if self.nominal:
            self.give(ev.Tick(), until)
            return
        elapsed = until - self.now
        self._move(elapsed)
        for share in (0.5, 1.0):
            at = until - elapsed * (1 - share)
            for board in self.robot.boards.values():
                if self.ended:
                    return
                self.give(self._frame(board.id), at)
                self._resolve("accepted", at)

    def _move(self, elapsed: float) -> None:
        names = self.robot.vocabulary.numbers
        body = self.state.robot
        self.signals |= joints_that_obey(self.robot, body)
        for wheel in self.robot.wheels:
            turned = 3.0 * body.values[wheel.slot] * elapsed
            self.signals[names[wheel.angle]] = self.signals.get(names[wheel.angle], 0.0) + turned

    def _frame(self, board: int) -> ev.SensorFrame:
        channels = self.robot.boards[board].channels
        values = [0.0] * (1 + max(place for place, _, _ in channels))
        for place, target, scale in channels:
            name = self.robot.vocabulary.numbers[target]
            resting = 9.81 if name == "acc_z" else 0.0
            values[place] = self.signals.get(name, resting) / scale
        return ev.SensorFrame(board, tuple(values))

    def _resolve(self, status: Any, at: float) -> None:
        # Whoever repeats an array of unknown fate gets a result for it again.
        if self.unresolved and self.sent is not None and not self.ended:
            self.give(ev.SubmitResult(self.sent.setpoint_id, status, "because"), at)

    def give(self, event: ev.Event, at: float | None = None) -> None:
        self.now = max(self.now, self.now if at is None else at)
        before = self.state
        self.given.append((self.now, event))
        self.state, effects = self.engine.step(before, event, self.now)
        result = event if isinstance(event, ev.SubmitResult) else None
        ours = self.sent.setpoint_id if self.sent and self.unresolved else None
        if result is not None and result.setpoint_id == ours:
            if result.status == "accepted":
                self.accepted = self.sent
            self.unresolved = result.status == "unknown"
        if isinstance(event, ev.OperatorCommand):
            self.commanded_in_pause = self.commanded_in_pause or before.mission.paused
        self._check(event, before, effects)
        self._check_waking()

    # --- what must hold ---

    def _check(
        self, event: ev.Event | None, before: EngineState, effects: tuple[fx.Effect, ...]
    ) -> None:
        self.effects += effects
        mission, body = self.state.mission, self.state.robot
        if not mission.paused:
            self.commanded_in_pause = False
        if mission.ending or (mission.paused and not self.commanded_in_pause):
            assert body.loops == (), "a loop runs in the safe state"
        if body.motion is None:
            assert body.seekers == (), "a position loop has outlived its command"
        for number, effect in enumerate(effects):
            self._note(effect)
            if isinstance(effect, fx.Ended):
                assert number == len(effects) - 1, "something follows the end"
        assert any(isinstance(effect, fx.Ended) for effect in effects) == (
            self.ended and not (event is not None and before.mission.ended)
        )
        if self.ended:
            self._check_end()
        self._check_chart(event, before)

    def _note(self, effect: fx.Effect) -> None:
        if isinstance(effect, fx.Setpoints):
            self._check_setpoints(effect)
        elif isinstance(effect, fx.CommandStatus):
            self._check_status(effect)
        elif isinstance(effect, fx.Ask):
            assert bool(effect.question) != bool(self.question)
            self.question = effect.choices
        elif isinstance(effect, fx.WaitArmed):
            self.waiting_for = effect.triggers
        elif isinstance(effect, fx.WakeAt):
            assert effect.at_s >= self.now - ROUNDING_S, "it would have been woken in the past"

    def _check_setpoints(self, new: fx.Setpoints) -> None:
        old, body = self.sent, self.state.robot
        for slot, value in zip(self.robot.slots, new.values, strict=True):
            assert slot.low <= value <= slot.high, f"{slot.name} = {value}"
        if old is not None and new.setpoint_id == old.setpoint_id:
            assert new == old, "one id stands for one array"
            assert self.unresolved
        else:
            assert new.setpoint_id == (old.setpoint_id + 1 if old else 1)
            if self.unresolved and new.setpoint_id == body.next_id - 1:
                assert body.flight is not None
                stops = body.flight.purpose == "stop"
                assert stops or self.streamed, "only the safe stop may overtake an awaited array"
            self.streamed = body.flight is not None and body.flight.purpose == "stream"
        if self.state.mission.paused and not self.commanded_in_pause:
            assert all(new.values[slot] == 0 for slot in self.robot.safe_zero)
        self.sent, self.unresolved = new, True

    def _check_status(self, status: fx.CommandStatus) -> None:
        match status.status:
            case "sent":
                assert not self.active
                self.active = status.name
            case "accepted":
                assert self.active == status.name
            case "done" | "failed":
                assert self.active == status.name
                self.active = ""
            case "refused":
                assert status.reason.split(":")[0] in ("unneeded", "impossible")
            case "skipped":
                self.active = "" if self.active == status.name else self.active

    def _check_end(self) -> None:
        assert not self.active
        assert not self.question, "a question was left open"
        if self.sent is None:
            return
        assert all(self.sent.values[slot] == 0 for slot in self.robot.safe_zero)
        base = self.accepted
        loops = self._slots_of_loops()
        if base is None:
            return
        for slot, (new, old) in enumerate(zip(self.sent.values, base.values, strict=True)):
            if slot not in self.robot.safe_zero and slot not in loops:
                assert new == old, f"{self.robot.slots[slot].name} was changed by the safe stop"

    def _slots_of_loops(self) -> set[int]:
        """Slots that some state brings to an angle or a torque: a loop may have left anything."""
        names = self.robot.table.configurations[self.state.robot.configuration]
        return {
            write.slot
            for control in self.robot.controls
            for region, name in enumerate(names)
            for stage in control.actuation[region][name]
            for write in stage
            if write.how in ("seek", "bear")
        }

    def _check_chart(self, event: ev.Event | None, before: EngineState) -> None:
        old, new = before.robot.configuration, self.state.robot.configuration
        if old == new:
            return
        assert isinstance(event, ev.SubmitResult)
        assert event.status == "accepted"
        motion = before.robot.motion
        assert motion is not None
        assert self.robot.table.follow(old, motion.command) == new
        confirmed = confirmed_parts(self.robot, before.robot)
        if confirmed and not confirmed & self.robot.held[new]:
            assert self.robot.commands[motion.command].lets_go

    def _check_waking(self) -> None:
        """Whoever is woken as asked gets on; nobody is woken forever in one moment."""
        for _ in range(MOST_TICKS_IN_A_MOMENT):
            if self.ended or self.state.wake_at_s > self.now:
                return
            before = self.state
            self.given.append((self.now, ev.Tick()))
            self.state, effects = self.engine.step(before, ev.Tick(), self.now)
            self._check(ev.Tick(), before, effects)
        raise AssertionError("time stands still")


def replay(course: Course) -> list[fx.Effect]:
    """The effects of the same events given once more to a new engine."""
    engine = Engine(course.robot, course.program, nominal=course.nominal)
    state, first = engine.start(0.0)
    effects = list(first)
    for at, event in course.given:
        state, more = engine.step(state, event, at)
        effects += more
    return effects
