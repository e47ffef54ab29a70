"""A mission run on the production engine in a world that goes by lot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf, isfinite, isnan, nan
from random import Random

from pirate_sm.checking.exploring.signal_ranges import ANYTHING, ranges
from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.core._engine.robot import robot_state
from pirate_sm.core._engine.safety import STARTS_AGAIN
from pirate_sm.core._engine.state import OUTSIDE
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.expressions import EnumType, Expression, tree
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Branch, Program, Question, Wait
from pirate_sm.core.robot import at_rest_in


def conditions_in(program: Program) -> list[Expression]:
    """Every condition of the program."""
    found = [each.condition for each in program.instructions if isinstance(each, Branch)]
    for each in program.instructions:
        if isinstance(each, Wait):
            found += [trigger.condition for trigger in each.triggers if trigger.condition]
    return found


class Shown:
    """Values that make a difference to the conditions of a mission, inside the signals' ranges."""

    def __init__(self, loaded: LoadedMission) -> None:
        trees = [each.tree for each in conditions_in(loaded.program)]
        trees += [fault.when.tree for fault in loaded.robot.faults]
        nodes = [node for each in trees for node in tree.walk(each)]
        spans = ranges(loaded.loaded_robot.profile, loaded.robot)
        marks = {0.0, *(node.value for node in nodes if isinstance(node, tree.Number))}
        near = [m + d for m in sorted(marks) for d in (-0.3, -1e-3, 0.0, 1e-3, 0.3)]
        signals = sorted({(n.name, n.kind) for n in nodes if isinstance(n, tree.Signal)})
        self.numbers: dict[str, list[float]] = {}
        self.words: dict[str, list[str | None]] = {}
        for name, kind in signals:
            if name in loaded.robot.regions:
                continue
            if kind == "number":
                span = spans.get(name, ANYTHING)
                values = [value for value in (*near, -40.0, 40.0) if span.low <= value <= span.high]
                self.numbers[name] = [nan, *values]
            else:
                words = loaded.robot.vocabulary.types[name]
                assert isinstance(words, EnumType)
                self.words[name] = [None, *words.values]

    def any(self, lot: Random) -> ev.SignalReport:
        """Some of the signals, each with one of its values."""
        numbers = [(name, lot.choice(values)) for name, values in self.numbers.items()]
        words = [(name, lot.choice(values)) for name, values in self.words.items()]
        return ev.SignalReport(
            tuple(each for each in numbers if lot.random() < 0.7),
            tuple(each for each in words if lot.random() < 0.7),
        )


@dataclass
class Run:
    """A run in which commands take their nominal time, as in a trace.

    Attributes:
        effects: What the engine did, in the order of events.
        situations: What mission and robot were in, see :func:`situation`, until it was ending.
    """

    loaded: LoadedMission
    shown: Shown
    lot: Random
    effects: list[tuple[fx.Effect, ...]] = field(default_factory=list)
    situations: list[tuple[object, ...]] = field(default_factory=list)
    given: list[tuple[float, ev.Event]] = field(default_factory=list)
    now: float = 0.0

    def __post_init__(self) -> None:
        self.engine = Engine(self.loaded.robot, self.loaded.program, nominal=True)
        self.state, effects = self.engine.start(0.0, [self.shown.any(self.lot)])
        self._note(effects)

    def go_on(self, most: int) -> None:
        """So many things have happened, or the mission has ended."""
        for _ in range(most):
            if self.state.mission.ended:
                return
            self._look_round()
            event, at = self._next()
            self._give(event, at)

    def _look_round(self) -> None:
        """Sensors may show something else."""
        if self.lot.random() < 0.5:
            self._give(self.shown.any(self.lot))

    @property
    def limit_has_passed(self) -> bool:
        """Whether the mission may have been ended by its time limit."""
        return self.now >= self.loaded.program.time_limit_s

    def _give(self, event: ev.Event, at: float | None = None) -> None:
        self.now = self.now if at is None else max(at, self.now)
        self.given.append((self.now, event))
        self.state, effects = self.engine.step(self.state, event, self.now)
        self._note(effects)

    def _note(self, effects: tuple[fx.Effect, ...]) -> None:
        self.effects.append(effects)
        mission = self.state.mission
        # In a trace no position loop runs, so no array of one holds up the next command.
        held_up = self.state.robot.flight is not None and not mission.begun
        if not (mission.ended or mission.ending or self.limit_has_passed or held_up):
            self.situations.append(situation(self.state))

    def _next(self) -> tuple[ev.Event, float | None]:
        lot, body = self.lot, self.state.robot
        if lot.random() < 0.03:
            fault = self._fault()
            if fault is not None:
                return fault, None
        if body.flight is not None and lot.random() < 0.85:
            if body.flight.resend_at_s < inf:
                return ev.Tick(), body.flight.resend_at_s
            status = lot.choice(["accepted"] * 25 + ["rejected", "superseded", "unknown"])
            if status in {"rejected", "superseded"} and body.flight.purpose != "gate":
                status = "accepted"  # else the backend has failed, and all is over
            return ev.SubmitResult(body.flight.setpoint_id, status, "by lot"), None
        if body.motion is not None and body.flight is None and lot.random() < 0.1:
            return ev.CommandFailed("by lot"), None
        return self._in_time()

    def _in_time(self) -> tuple[ev.Event, float | None]:
        lot, wake = self.lot, self.state.wake_at_s
        it = self.loaded.program.instructions[self.state.mission.pc]
        said: list[str] = []
        if isinstance(it, Wait):
            said = [trigger.answer for trigger in it.triggers if trigger.answer]
        elif isinstance(it, Question):
            said = [choice for choice, _ in it.choices]
        if said and lot.random() < 0.4:
            return ev.Answer(lot.choice([*said, *said, "nonsense"])), None
        if lot.random() < 0.3:
            part = lot.choice([0.0, 0.3, 0.9])
            return ev.Tick(), self.now + (part * (wake - self.now) if isfinite(wake) else 1.0)
        return ev.Tick(), wake if isfinite(wake) else self.now + 1.0

    def _fault(self) -> ev.Event | None:
        """A fault that can be: one that a rule tells only where the rule holds."""
        robot = self.loaded.robot
        handled = [each.code for each in self.loaded.program.handlers[self.state.mission.pc]]
        codes = [code for code, catchable in robot.fault_codes.items() if catchable]
        code = self.lot.choice([*handled * 3, *codes])
        rules = [fault for fault in robot.faults if fault.code == code]
        words = (*robot_state.obeyed(robot, self.state.robot), *self.state.words[-len(OUTSIDE) :])
        numbers = self.state.sensing.shown
        if not rules:
            return ev.FaultReport(code, "by lot")
        true = (rule for rule in rules if rule.when.evaluate(numbers, words) is True)
        return next((ev.FaultReport(code, rule.message) for rule in true), None)


class Measured(Run):
    """A run in which sensors tell whether a command is done, as with a robot or a simulator."""

    def __post_init__(self) -> None:
        self.engine = Engine(self.loaded.robot, self.loaded.program, nominal=False)
        self.signals: dict[str, float] = {}
        # The check takes it that the sensors confirm what is declared.
        body = at_rest_in(self.loaded.robot, self.loaded.program.start_configuration)
        self.state, effects = self.engine.start(0.0, [*self._frames()], body=body)
        self._note(effects)

    def _look_round(self) -> None:
        """Time passes; the robot mostly does what it is told, and all boards tell so."""
        lot, robot = self.lot, self.loaded.robot
        step_s = lot.choice([0.05, 0.2, 0.5])
        self.now += step_s
        if lot.random() < 0.9:
            self._move(step_s)
        for frame in self._frames():
            self._give(frame)
        if robot.detector_words and lot.random() < 0.1:
            self._give(ev.DetectorWord(lot.choice(robot.detector_words), lot.choice([0.1, 2.0])))
        if lot.random() < 0.05:
            self._give(ev.EnvironmentReport(lot.choice(["Out", "Straight", "Joint"]), 0, 0, 0.1))

    def _in_time(self) -> tuple[ev.Event, float | None]:
        event, at = super()._in_time()
        return (event, None) if isinstance(event, ev.Tick) else (event, at)

    def _fault(self) -> ev.Event | None:
        """What a rule tells, the engine finds by itself.

        The check takes it that a robot that comes back is the known one. This world does not show
        enough for sensors to confirm that, so its controller is never away.
        """
        fault = super()._fault()
        own = {each.code for each in self.loaded.robot.faults} | STARTS_AGAIN
        return None if isinstance(fault, ev.FaultReport) and fault.code in own else fault

    def _move(self, step_s: float) -> None:
        names, body = self.loaded.robot.vocabulary.numbers, self.state.robot
        for loop in body.seekers:
            self.signals[names[loop.angle]] = loop.target_rad
        for slot, value in zip(self.loaded.robot.slots, body.values, strict=True):
            if slot.torque >= 0:
                self.signals[names[slot.torque]] = value
            if slot.unit == "angle" and slot.angle >= 0 and not isnan(value):
                self.signals[names[slot.angle]] = value
        for wheel in self.loaded.robot.wheels:
            turned = 3.0 * body.values[wheel.slot] * step_s
            self.signals[names[wheel.angle]] = self.signals.get(names[wheel.angle], 0.0) + turned

    def _frames(self) -> Iterator[ev.SensorFrame]:
        names = self.loaded.robot.vocabulary.numbers
        for board in self.loaded.robot.boards.values():
            values = [0.0] * board.length
            blind = self.lot.random() < 0.01
            for place, target, scale in board.channels:
                resting = 9.81 if names[target] == "acc_z" else 0.0
                values[place] = nan if blind else self.signals.get(names[target], resting) / scale
            yield ev.SensorFrame(board.id, tuple(values))


def situation(state: EngineState) -> tuple[object, ...]:
    """Where mission and robot are, without times."""
    mission, body = state.mission, state.robot
    if mission.diverting is not None:  # where the fault came up matters no more
        return mission.diverting.go, mission.stopped, body.configuration, body.marks
    return mission.pc, mission.begun, mission.handling, body.configuration, body.marks
