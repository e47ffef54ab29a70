"""How near a run came to going wrong: limits nearly reached, faults nearly raised.

Every call has a share: 1 is where it would have happened, so the nearest are the largest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from math import inf, isinf, isnan
from typing import NamedTuple

from pirate_sm.engine.mission.program import Program, Wait
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import RobotState, obeyed
from pirate_sm.engine.state import EngineState
from pirate_sm.expressions import tree
from pirate_sm.model.effects import CommandStatus, Effect, Fault, TriggerFired, WaitArmed
from pirate_sm.model.events import Event, SensorFrame
from pirate_sm.runtime.rule_margins import margins_of


class NearMiss(NamedTuple):
    """Something that nearly happened.

    Attributes:
        about: What it is about, the same in every run.
        text: How near it came, with numbers.
        share: How near, of 1.
        at_s: When.
    """

    about: str
    text: str
    share: float
    at_s: float


class NearMisses:
    """A tap that notes the nearest call of each kind.

    Args:
        robot: Whose faults they are.
        program: Whose limits they are.
    """

    def __init__(self, robot: RobotSpec, program: Program) -> None:
        self._robot = robot
        self._program = program
        self._state: Callable[[], EngineState | None] = lambda: None
        self._calls: dict[str, NearMiss] = {}
        self._over = False  # the safe stop is no part of it
        missions = _Commands(program), _Waits(), _Triggers(program)
        self._notes = (*missions, _Words(robot, program), _Faults(robot))

    def follow(self, state: Callable[[], EngineState | None]) -> None:
        """Read the engine's state from here; it is None before the engine has started."""
        self._state = state

    def nearest(self) -> list[NearMiss]:
        """Return the nearest call of each kind, the nearest first."""
        return sorted(self._calls.values(), key=lambda call: -call.share)

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        *,
        body: RobotState | None = None,
        paused: bool = False,
    ) -> None:
        """Look at the beginning of the run."""
        self._look(None, now_s, effects)

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Look at a step."""
        self._look(event, now_s, effects)

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Do nothing: what is done past the engine is no close call."""

    def _look(self, event: Event | None, now_s: float, effects: Sequence[Effect]) -> None:
        state = self._state()
        if state is None or self._over:
            return
        self._over = state.mission.ending is not None or state.mission.ended
        moment = _Step(state, event, now_s, effects)
        for each in self._notes:
            for call in each.look(moment):
                self._note(call)
        self._limit(now_s)

    def _limit(self, now_s: float) -> None:
        limit_s = self._program.time_limit_s
        if not isinf(limit_s):
            text = f"the mission took {now_s:.1f} s of its time limit of {limit_s:g} s"
            self._note(NearMiss("time limit", text, now_s / limit_s, now_s))

    def _note(self, call: NearMiss) -> None:
        before = self._calls.get(call.about)
        if before is None or call.share > before.share:
            self._calls[call.about] = call


@dataclass(frozen=True)
class _Step:
    """One step of the engine with the state after it."""

    state: EngineState
    event: Event | None
    now_s: float
    effects: Sequence[Effect]


@dataclass
class _Commands:
    """How long commands took of the time that they have."""

    program: Program
    _under_way: tuple[float, float] = (inf, inf)  # when accepted, and how long it may take

    def look(self, moment: _Step) -> list[NearMiss]:
        """Return the commands that ended in this moment."""
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
class _Waits:
    """How long waits took of their limits."""

    _armed: dict[str, tuple[float, float]] = field(default_factory=dict)

    def look(self, moment: _Step) -> list[NearMiss]:
        """Return the waits that ended in this moment."""
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
class _Triggers:
    """Conditions that held for a part of the time that they must, and fell away."""

    program: Program
    _began: dict[int, float] = field(default_factory=dict)
    _at: int = -1

    def look(self, moment: _Step) -> list[NearMiss]:
        """Return the conditions that have just fallen away."""
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
                text = f"{about} held for {held_s:.2f} s and fell away"
                calls.append(NearMiss(about, text, held_s / trigger.held_s, moment.now_s))
        return calls


class _Words:
    """How soon after a detector's word had ended a wait the word was gone."""

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

    def look(self, moment: _Step) -> list[NearMiss]:
        """Return the word that has just gone, if a wait has used it."""
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


class _Faults:
    """Fault rules that held for a part of the time that they must, and signals near their limits.

    Args:
        robot: Whose rules they are.
    """

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        self._levels = [margins_of(rule, robot.vocabulary) for rule in robot.faults]
        self._body: RobotState | None = None
        self._states: tuple[str | None, ...] = ()

    def look(self, moment: _Step) -> list[NearMiss]:
        """Return the faults of this moment, and the rules of the board that has just reported."""
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

    def _held(self, index: int, moment: _Step) -> Iterator[NearMiss]:
        rule, since_s = self._robot.faults[index], moment.state.faults.since[index]
        if rule.held_s and not isnan(since_s):
            held_s = min(moment.now_s - since_s, rule.held_s)
            text = f"{rule.code} held for {held_s:.2f} s of {rule.held_s:g} s: {rule.message}"
            yield NearMiss(rule.code, text, held_s / rule.held_s, moment.now_s)

    def _near(self, index: int, moment: _Step) -> Iterator[NearMiss]:
        rule, state = self._robot.faults[index], moment.state
        if state.robot is not self._body:
            self._body, self._states = state.robot, obeyed(self._robot, state.robot)
        words = (*self._states, *state.words[len(self._states) :])
        for level in self._levels[index]:
            nearness, text = level.seen(state.sensing.numbers, words, moment.now_s)
            if 0 < nearness < 1:
                yield NearMiss(rule.code, f"{rule.code}: {text}", nearness, moment.now_s)
