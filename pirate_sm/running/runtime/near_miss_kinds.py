"""The kinds of near misses: commands, waits, triggers, words and faults, one class for each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import inf, isinf, isnan
from typing import NamedTuple

from pirate_sm.core.effects import CommandStatus, Effect, Fault, TriggerFired, WaitArmed
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event, SensorFrame
from pirate_sm.core.expressions import tree
from pirate_sm.core.program import Program, Wait
from pirate_sm.core.robot import RobotSpec, RobotState, obeyed
from pirate_sm.running.runtime.rule_margins import margins_of


class NearMiss(NamedTuple):
    """A fault or a limit that was nearly reached.

    Attributes:
        about: Its subject, the same in every run.
        text: How near it came, with numbers.
        share: How near it came, as a share of the limit.
        at_s: Time, s.
    """

    about: str
    text: str
    share: float
    at_s: float


@dataclass(frozen=True)
class EngineStep:
    """One step of the engine, with the state after it."""

    state: EngineState
    event: Event | None
    now_s: float
    effects: Sequence[Effect]


@dataclass
class CommandTimes:
    """How much of their time limit commands took."""

    program: Program
    _under_way: tuple[float, float] = (inf, inf)  # time of acceptance, and time limit

    def look(self, moment: EngineStep) -> list[NearMiss]:
        """Return a near miss for each command that ended in this step."""
        calls = []
        for effect in moment.effects:
            if not isinstance(effect, CommandStatus):
                continue
            motion = moment.state.robot.motion
            if effect.status == "accepted" and motion is not None:
                self._under_way = moment.now_s, motion.timeout_s
            elif effect.status in ("done", "failed") and not isinf(self._under_way[0]):
                since_s, timeout_s = self._under_way
                self._under_way = inf, inf
                took_s = moment.now_s - since_s
                text = f"took {took_s:.1f} s of the {timeout_s:g} s that it has"
                if effect.status == "failed":
                    text = f"failed after {took_s:.1f} s: {effect.reason}"
                share = 1.0 if effect.status == "failed" else took_s / timeout_s
                name = f"{effect.name} ({effect.place})"
                calls.append(NearMiss(name, f"{name} {text}", share, moment.now_s))
        return calls


@dataclass
class WaitTimes:
    """How much of their time limit waits took."""

    _armed: dict[str, tuple[float, float]] = field(default_factory=dict)

    def look(self, moment: EngineStep) -> list[NearMiss]:
        """Return a near miss for each wait that ended in this step."""
        calls = []
        for effect in moment.effects:
            if isinstance(effect, WaitArmed) and not isinf(effect.deadline_s):
                self._armed[effect.phase] = moment.now_s, effect.deadline_s
            elif isinstance(effect, TriggerFired) and effect.phase in self._armed:
                since_s, deadline_s = self._armed.pop(effect.phase)
                took_s, limit_s = moment.now_s - since_s, deadline_s - since_s
                if limit_s <= 0:
                    continue
                about = f"the wait of {effect.phase}"
                text = f"{about} took {took_s:.1f} s of its limit of {limit_s:g} s"
                share = 1.0 if effect.trigger == "within" else took_s / limit_s
                calls.append(NearMiss(about, text, share, moment.now_s))
        return calls


@dataclass
class TriggerTimes:
    """Conditions that held for a part of the required time and then became false."""

    program: Program
    _began: dict[int, float] = field(default_factory=dict)
    _at: int = -1

    def look(self, moment: EngineStep) -> list[NearMiss]:
        """Return a near miss for each condition that has just become false."""
        mission = moment.state.mission
        if mission.pc != self._at:
            self._at, self._began = mission.pc, {}
        it = self.program.instructions[mission.pc]
        if not isinstance(it, Wait):
            return []
        calls = []
        for index, since_s in enumerate(mission.since):
            trigger = it.triggers[index]
            if not isnan(since_s):
                self._began[index] = since_s
            elif index in self._began and trigger.held_s:
                held_s = mission.clock(moment.now_s) - self._began.pop(index)
                about = f"the trigger '{trigger.text}' of {it.phase}"
                text = f"{about} held for {held_s:.2f} s and became false again"
                calls.append(NearMiss(about, text, held_s / trigger.held_s, moment.now_s))
        return calls


class WordTimes:
    """How soon a detector's word expired after it had ended a wait."""

    def __init__(self, robot: RobotSpec, program: Program) -> None:
        self._index = len(robot.regions)
        self._word: str | None = None
        self._since_s = 0.0
        self._used_s = inf
        self._hearing = {
            (it.phase, trigger.name)
            for it in program.instructions
            if isinstance(it, Wait)
            for trigger in it.triggers
            if trigger.condition is not None and self._hears(trigger.condition.tree)
        }

    def look(self, moment: EngineStep) -> list[NearMiss]:
        """Return a near miss for a word that has just expired, if a wait used it."""
        calls = []
        words, now_s = moment.state.words, moment.now_s
        word = words[self._index] if self._index < len(words) else None
        if word != self._word:
            if self._word is not None and not isinf(self._used_s):
                lasted_s, used_s = now_s - self._since_s, self._used_s - self._since_s
                about = f"the detector's word '{self._word}'"
                text = f"{about} was used after {used_s:.2f} s and gone after {lasted_s:.2f} s"
                share = used_s / lasted_s if lasted_s > 0 else 1.0
                calls.append(NearMiss(about, text, share, self._used_s))
            self._word, self._since_s, self._used_s = word, now_s, inf
        for effect in moment.effects:
            if isinstance(effect, TriggerFired) and isinf(self._used_s):
                heard = (effect.phase, effect.trigger) in self._hearing
                self._used_s = now_s if heard else inf
        return calls

    def _hears(self, condition: tree.Node) -> bool:
        return any(
            isinstance(node, tree.Signal) and node.kind == "word" and node.index == self._index
            for node in tree.walk(condition)
        )


class FaultMargins:
    """Fault rules that held for a part of the required time, and signals near their limits.

    Args:
        robot: The robot with the rules.
    """

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        self._levels = [margins_of(rule, robot.vocabulary) for rule in robot.faults]
        self._body: RobotState | None = None
        self._states: tuple[str | None, ...] = ()

    def look(self, moment: EngineStep) -> list[NearMiss]:
        """Return near misses of this step's faults and of the rules of the board that reported."""
        calls = []
        for effect in moment.effects:
            if isinstance(effect, Fault):
                text = f"{effect.code} came up: {effect.message}"
                calls.append(NearMiss(effect.code, text, 1.0, moment.now_s))
        event = moment.event
        board = self._robot.boards.get(event.board) if isinstance(event, SensorFrame) else None
        for index in board.faults if board is not None else ():
            calls += [*self._held(index, moment), *self._near(index, moment)]
        return calls

    def _held(self, index: int, moment: EngineStep) -> Iterator[NearMiss]:
        rule, since_s = self._robot.faults[index], moment.state.faults.since[index]
        if rule.held_s and not isnan(since_s):
            held_s = min(moment.now_s - since_s, rule.held_s)
            text = f"{rule.code} held for {held_s:.2f} s of {rule.held_s:g} s: {rule.message}"
            yield NearMiss(rule.code, text, held_s / rule.held_s, moment.now_s)

    def _near(self, index: int, moment: EngineStep) -> Iterator[NearMiss]:
        rule, state = self._robot.faults[index], moment.state
        if state.robot is not self._body:
            self._body, self._states = state.robot, obeyed(self._robot, state.robot)
        words = (*self._states, *state.words[len(self._states) :])
        for level in self._levels[index]:
            nearness, text = level.seen(state.sensing.numbers, words, moment.now_s)
            if 0 < nearness < 1:
                yield NearMiss(rule.code, f"{rule.code}: {text}", nearness, moment.now_s)
