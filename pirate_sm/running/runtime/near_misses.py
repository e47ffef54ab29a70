"""How near a run came to a fault or a limit.

Each near miss has a share of its limit: at 1 it would have happened, so the largest are nearest.
There is one class for each kind: commands, waits, triggers, words and faults.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from math import inf, isinf, isnan
from typing import NamedTuple

from pirate_sm.core.effects import CommandStatus, Effect, Fault, TriggerFired, WaitArmed
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event, SensorFrame
from pirate_sm.core.expressions import BOOLEAN, Expression, NumberType, Vocabulary, tree
from pirate_sm.core.program import Program, Wait
from pirate_sm.core.resuming import AS_DECLARED, Beginning
from pirate_sm.core.robot import FaultSpec, RobotSpec, RobotState, obeyed
from pirate_sm.core.sensing import Glide
from pirate_sm.core.units import DIMENSIONLESS, Dimension, format_quantity

# --- fault rules ----------------------------------------------------------------------------------


Numbers = Sequence[float]
Words = Sequence[str | None]


class _Limit(NamedTuple):
    """One comparison of the rule: a value and its limit."""

    what: str
    value: Expression
    limit: Expression
    rises: bool
    dimension: Dimension


class RuleMargin:
    """Follows one way for a rule to hold: comparisons that must all be true, and other conditions.

    Args:
        limits: The comparisons.
        rest: The other conditions; None if there are none.
        held_s: How long the rule must hold, s.
    """

    def __init__(self, limits: tuple[_Limit, ...], rest: Expression | None, held_s: float) -> None:
        self._limits = limits
        self._rest = rest
        self._held_s = held_s
        self._since_s: float | None = None
        self._least: deque[tuple[float, float, Callable[[], str]]] = deque()

    def seen(self, numbers: Numbers, words: Words, now_s: float) -> tuple[float, str]:
        """Return how near the rule has been throughout the time for which it must hold.

        Args:
            numbers: The present signals.
            words: The present words.
            now_s: Time, not earlier than in the last call.

        Returns:
            A share, 1 if the rule holds, and a sentence about the comparison.
        """
        if self._rest is not None and self._rest.evaluate(numbers, words) is not True:
            self._since_s = None
            self._least.clear()
            return 0.0, ""
        if self._since_s is None:
            self._since_s = now_s
        share, sentence = self._now(numbers, words)
        while self._least and self._least[-1][1] >= share:
            self._least.pop()
        self._least.append((now_s, share, sentence))
        while self._least[0][0] < now_s - self._held_s:
            self._least.popleft()
        if now_s - self._since_s < self._held_s:
            return 0.0, ""
        _, least, sentence = self._least[0]
        return least, sentence() if 0 < least < 1 else ""

    def _now(self, numbers: Numbers, words: Words) -> tuple[float, Callable[[], str]]:
        """Return the current share of the comparison that is farthest from its limit."""
        least, sentence = 1.0, str
        for each in self._limits:
            value, limit = each.value.evaluate(numbers, words), each.limit.evaluate(numbers, words)
            share = _share(value, limit, each.rises)
            if share < least:
                least, sentence = share, _Sentence(each, value, limit, self._held_s)  # type: ignore[assignment,arg-type]
        return least, sentence


class _Sentence(NamedTuple):
    """Makes the sentence about a comparison when it is needed."""

    limit: _Limit
    value: float
    bound: float
    held_s: float

    def __call__(self) -> str:
        """Return the sentence."""
        value_text, bound = (_quantity(x, self.limit.dimension) for x in (self.value, self.bound))
        side = "up to" if self.limit.rises else "down to"
        held = f" for {self.held_s:g} s" if self.held_s else ""
        return f"{self.limit.what} came {side} {value_text}{held}, the limit is {bound}"


def margins_of(rule: FaultSpec, vocabulary: Vocabulary) -> list[RuleMargin]:
    """Return each way for the rule to hold that has a limit."""
    ways = rule.when.tree.parts if isinstance(rule.when.tree, tree.Or) else (rule.when.tree,)
    found = []
    for way in ways:
        parts = way.parts if isinstance(way, tree.And) else (way,)
        limits = tuple(_limit(each, vocabulary) for each in parts if isinstance(each, tree.Compare))
        rest = tuple(each for each in parts if not isinstance(each, tree.Compare))
        condition = Expression("", BOOLEAN, tree.And(rest)) if rest else None
        if limits:
            found.append(RuleMargin(limits, condition, rule.held_s))
    return found


def _limit(compare: tree.Compare, vocabulary: Vocabulary) -> _Limit:
    """Return the comparison as a value and its limit; the side with signals is the value."""
    left, right, rises = compare.left, compare.right, compare.operator in (">", ">=")
    if not list(_signals(left)):
        left, right, rises = right, left, not rises
    dimension = _dimension(left, vocabulary)
    kind = NumberType(dimension)
    return _Limit(
        text_of(left), Expression("", kind, left), Expression("", kind, right), rises, dimension
    )


def _share(value: object, limit: object, rises: bool) -> float:
    """Return how near a value is to its limit: 1 beyond it, 0 if either is not positive."""
    if not isinstance(value, float | int) or not isinstance(limit, float | int):
        return 0.0
    small, large = (value, limit) if rises else (limit, value)
    if small >= large:
        return 1.0
    return small / large if small > 0 else 0.0


def _signals(node: tree.Node) -> Iterator[tree.Signal]:
    return (each for each in tree.walk(node) if isinstance(each, tree.Signal))


def _dimension(node: tree.Node, vocabulary: Vocabulary) -> Dimension:
    """Return the dimension of a number's signals; none for products."""
    products = (each for each in tree.walk(node) if isinstance(each, tree.Arithmetic))
    if any(each.operator in "*/" for each in products):
        return DIMENSIONLESS
    kinds = (vocabulary.types[each.name] for each in _signals(node))
    return next((each.dimension for each in kinds if isinstance(each, NumberType)), DIMENSIONLESS)


def text_of(node: tree.Node) -> str:
    """Return a number of a condition as people write it."""
    match node:
        case tree.Signal(name=name):
            return name
        case tree.Number(value=value):
            return f"{value:g}"
        case tree.Negate(operand=operand):
            return f"-{text_of(operand)}"
        case tree.Call(function=function, arguments=arguments):
            return f"{function}({', '.join(map(text_of, arguments))})"
        case tree.Arithmetic(operator=operator, left=left, right=right):
            return f"({text_of(left)} {operator} {text_of(right)})"
        case _:
            return "a condition"


def _quantity(value: float, dimension: Dimension) -> str:
    return format_quantity(float(f"{value:.3g}"), dimension)


# --- kinds ----------------------------------------------------------------------------------------


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


# --- all of a run ---------------------------------------------------------------------------------


class NearMisses:
    """A tap that keeps the nearest miss of each kind.

    Args:
        robot: The robot with the fault rules.
        program: The mission with the limits.
    """

    stepwise = True
    due_s = -inf

    def __init__(self, robot: RobotSpec, program: Program) -> None:
        self._program = program
        self._state: Callable[[], EngineState | None] = lambda: None
        self._calls: dict[str, NearMiss] = {}
        self._over = False  # the safe stop does not count
        missions = CommandTimes(), WaitTimes(), TriggerTimes(program)
        self._notes = (*missions, WordTimes(robot, program), FaultMargins(robot))

    def follow(self, state: Callable[[], EngineState | None]) -> None:
        """Read the engine's state from here; it is None before the engine has started."""
        self._state = state

    def nearest(self) -> list[NearMiss]:
        """Return the nearest miss of each kind, the nearest first."""
        return sorted(self._calls.values(), key=lambda call: -call.share)

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        begins: Beginning = AS_DECLARED,
    ) -> None:
        """Look at the start of the run."""
        self._look(None, now_s, effects)

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Look at a step."""
        self._look(event, now_s, effects)

    def secure(self) -> None:
        """Do nothing: what it notes lives no longer than this program."""

    def take_glide(self, glide: Glide) -> None:
        """Look at each step of a glide."""
        for now_s, event, effects in glide.in_order():
            self.take(event, now_s, effects)

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Do nothing: actions past the engine do not count."""

    def _look(self, event: Event | None, now_s: float, effects: Sequence[Effect]) -> None:
        state = self._state()
        if state is not None:
            self.look(state, event, now_s, effects)

    def look(
        self, state: EngineState, event: Event | None, now_s: float, effects: Sequence[Effect]
    ) -> None:
        """Look at a step of the engine and the state after it."""
        if self._over:
            return
        self._over = state.mission.ending is not None or state.mission.ended
        moment = EngineStep(state, event, now_s, effects)
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
