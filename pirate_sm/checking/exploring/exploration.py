"""The result of an exploration: states, the steps between them, and their index by places."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isnan
from typing import NamedTuple, TypeAlias

from pirate_sm.checking.actuation_in_force import Actuated
from pirate_sm.checking.exploring.conditions import BranchAnswers, StepAnswers
from pirate_sm.checking.exploring.possible_events import PossibleEvent
from pirate_sm.core.effects import (
    CommandStatus,
    Effect,
    Ended,
    Fault,
    Log,
    PhaseChange,
    TriggerFired,
    WaitArmed,
)
from pirate_sm.core.engine import EngineState
from pirate_sm.core.expressions import Vocabulary
from pirate_sm.core.program import ROUND_AND_ROUND, BranchKey, Program
from pirate_sm.core.robot import RobotSpec, safety
from pirate_sm.core.units import format_quantity

BEGINS = "\0begins "
"""Prefix of the log line that marks the beginning of a call, before its place."""

MISHAPS = frozenset({"rejected", "failed", "fault"})
"""Kinds of events that count as mishaps."""

WITHIN = "within"
"""The trigger name of a wait's time limit."""


class ExploredState(NamedTuple):
    """A state of the engine when it was first reached.

    Attributes:
        step: Index of the step that led here.
        sure: Whether it is reached without undecided assumptions.
    """

    state: EngineState
    now: float
    step: int
    sure: bool

    @property
    def over(self) -> bool:
        """Return whether the run is ending in this state."""
        return self.state.mission.ended or self.state.mission.ending is not None


class ExploredStep(NamedTuple):
    """A step between two states.

    Attributes:
        source: Index of the state before; -1 before the start.
        target: Index of the state after it.
        effects: The effects, without setpoints.
        moment: The answers of the conditions.
    """

    source: int
    target: int
    move: PossibleEvent
    effects: tuple[Effect, ...]
    moment: StepAnswers
    sure: bool

    @property
    def in_vain(self) -> bool:
        """Return whether a wait has reached its time limit."""
        return any(isinstance(e, TriggerFired) and e.trigger == WITHIN for e in self.effects)

    @property
    def went_wrong(self) -> bool:
        """Return whether it is a mishap, or a wait that has reached its time limit."""
        return self.move.kind in MISHAPS or self.in_vain


@dataclass
class Exploration:
    """Everything that can happen to a mission.

    Attributes:
        complete: False if the exploration reached its limits.
        work: The work done, limited by ``MOST_WORK``.
        branches: By the place of each branch the values of its condition.
        taken: By each branch of the mission that is taken the first step that takes it.
    """

    program: Program
    robot: RobotSpec
    nodes: list[ExploredState] = field(default_factory=list)
    steps: list[ExploredStep] = field(default_factory=list)
    complete: bool = True
    work: float = 0.0
    branches: Mapping[str, set[BranchAnswers]] = field(default_factory=dict)
    taken: dict[BranchKey, int] = field(default_factory=dict)
    _mishaps: list[int] = field(default_factory=list)

    def path(self, step: int) -> list[ExploredStep]:
        """Return the shortest event sequence from the start to this step."""
        found = []
        while step >= 0:
            found.append(self.steps[step])
            source = self.steps[step].source
            step = self.nodes[source].step if source >= 0 else -1
        return found[::-1]

    def mishaps(self, step: int) -> int:
        """Return the smallest number of mishaps up to and including this step."""
        if not self._mishaps:
            self._mishaps = fewest_mishaps([(e.source, e.target, e.went_wrong) for e in self.steps])
        here = self.steps[step]
        before = self._mishaps[here.source] if here.source >= 0 else 0
        return before + here.went_wrong

    def is_playable(self, step: int) -> bool:
        """Return whether a course of single events leads to this step."""
        return all(each.move.kind != "lasting" for each in self.path(step))


def fewest_mishaps(steps: Sequence[tuple[int, int, bool]]) -> list[int]:
    """Return for each state the smallest number of mishaps before it.

    Args:
        steps: For each step its source (-1 before the start), target, and whether it is a mishap.
    """
    after: dict[int, list[tuple[int, bool]]] = {}
    fewest = [len(steps)] * (1 + max(target for _, target, _ in steps))
    waiting: deque[int] = deque()
    for source, target, mishap in steps:
        if source < 0:
            fewest[target] = 0
            waiting.append(target)
        else:
            after.setdefault(source, []).append((target, mishap))
    while waiting:
        node = waiting.popleft()
        for target, mishap in after.get(node, ()):
            if fewest[node] + mishap < fewest[target]:
                fewest[target] = fewest[node] + mishap
                (waiting.append if mishap else waiting.appendleft)(target)
    return fewest


# --- index by places -----------------------------------------------------------------------------


WaitKey: TypeAlias = tuple[str, str]
"""The phase and place of a wait, ``file:line:col``."""


@dataclass
class Visits:
    """The results of a command or call each time it was reached, as indexes of steps."""

    name: str = ""
    given: list[int] = field(default_factory=list)
    skipped: list[int] = field(default_factory=list)
    unneeded: list[int] = field(default_factory=list)
    impossible: list[int] = field(default_factory=list)
    reasons: dict[int, str] = field(default_factory=dict)

    @property
    def refused(self) -> list[int]:
        """Return all steps in which it was refused."""
        return self.unneeded + self.impossible

    @property
    def never_fine(self) -> bool:
        """Return whether it was refused each time it was reached."""
        return bool(self.refused) and not self.given and not self.skipped


@dataclass
class Waiting:
    """The results of one wait.

    Attributes:
        armed: Steps in which it began.
        fired: For each trigger the steps in which it ended the wait.
        at_once: For each trigger how often it fired at the very beginning of the wait.
        actuated: In which configurations it began, each with the active control.
    """

    armed: list[int] = field(default_factory=list)
    fired: dict[str, list[int]] = field(default_factory=lambda: defaultdict(list))
    at_once: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    actuated: set[Actuated] = field(default_factory=set)

    @property
    def states(self) -> set[int]:
        """Return the configurations in which it began."""
        return {each.configuration for each in self.actuated}


@dataclass
class Explored:
    """The index of an exploration.

    Attributes:
        visits: Results of commands and calls, by ``file:line:col``.
        broken: By the message of a safety rule the first step that would violate it.
        ends: By the name of an end, or by outcome, the first step that leads to it.
    """

    found: Exploration
    visits: dict[str, Visits] = field(default_factory=lambda: defaultdict(Visits))
    waits: dict[WaitKey, Waiting] = field(default_factory=lambda: defaultdict(Waiting))
    phases: dict[str, int] = field(default_factory=dict)
    ends: dict[tuple[str, str], int] = field(default_factory=dict)
    broken: dict[str, int] = field(default_factory=dict)
    round_and_round: list[int] = field(default_factory=list)

    def sure(self, step: int) -> bool:
        """Return whether a step is reached without undecided assumptions."""
        return self.found.steps[step].sure


def index_exploration(found: Exploration) -> Explored:
    """Return the index of all steps of an exploration by their places in the mission."""
    book = Explored(found)
    for number, step in enumerate(found.steps):
        _enter(book, number, step)
    return book


def _enter(book: Explored, number: int, step: ExploredStep) -> None:
    _waited(book, number, step)
    for effect in step.effects:
        match effect:
            case CommandStatus():
                _command(book.visits[effect.place], number, effect)
            case Log():
                _begun(book, number, effect.message)
            case PhaseChange():
                book.phases.setdefault(effect.phase, number)
            case Fault(code=safety.RULE_BROKEN):
                book.broken.setdefault(effect.message, number)
            case Ended():
                _end(book, number, effect.outcome, effect.end, effect.message)
            case _:
                pass
    state = book.found.nodes[step.target].state.mission
    if state.ending is not None:
        _end(book, number, state.ending.outcome, state.ending.end, state.ending.message)


def _waited(book: Explored, number: int, step: ExploredStep) -> None:
    armed: WaitKey | None = None
    for effect in step.effects:
        match effect:
            case WaitArmed():
                armed = effect.phase, effect.place
                wait = book.waits[armed]
                wait.armed.append(number)
                body = book.found.nodes[step.target].state.robot
                wait.actuated.add(Actuated(body.configuration, body.control))
            case TriggerFired():
                key = effect.phase, effect.place
                wait = book.waits[key]
                wait.fired[effect.trigger].append(number)
                if armed == key:
                    wait.at_once[effect.trigger] += 1
            case _:
                pass


def _end(book: Explored, number: int, outcome: str, end: str, message: str) -> None:
    book.ends.setdefault((outcome, end), number)
    if message == ROUND_AND_ROUND:
        book.round_and_round.append(number)


def _begun(book: Explored, number: int, line: str) -> None:
    if line.startswith(BEGINS):
        book.visits[line.removeprefix(BEGINS)].given.append(number)


def _command(visits: Visits, number: int, effect: CommandStatus) -> None:
    visits.name = effect.name
    if effect.status == "refused":
        visits.reasons.setdefault(number, effect.reason)
    match effect.status:
        case "sent":
            visits.given.append(number)
        case "skipped":
            visits.skipped.append(number)
        case "refused" if effect.reason.startswith("unneeded"):
            visits.unneeded.append(number)
        case "refused":
            visits.impossible.append(number)
        case "accepted" | "done" | "failed":
            pass


# --- story ---------------------------------------------------------------------------------------


Written: TypeAlias = Callable[[str, str], str]
"""Returns the name of a command as written in the step at a place, ``file:line:col``."""


def _as_it_is(place: str, command: str) -> str:
    return command


def story(found: Exploration, step: int, written: Written = _as_it_is) -> tuple[str, ...]:
    """Return the story of a step: one sentence for each event that leads to it."""
    return tuple(sentence(found, each, written) for each in found.path(step))


def sentence(found: Exploration, step: ExploredStep, written: Written = _as_it_is) -> str:
    """Return the event of a step and its consequences."""
    said = [_what(found, step, written), *_consequences(step.effects, written)]
    shown = _shown(
        found.robot.vocabulary.with_changes, step.moment.answer.numbers, step.moment.answer.words
    )
    if shown and not any(isinstance(each, TriggerFired) for each in step.effects):
        said[0] += f" (with {shown})"
    return "; ".join(part for part in said if part)


def _what(found: Exploration, step: ExploredStep, written: Written) -> str:
    """Return the event itself as a sentence."""
    state = found.nodes[step.source].state if step.source >= 0 else None
    motion = state.robot.motion if state else None
    name = written(motion.place, found.robot.commands[motion.command].name) if motion else ""
    place = f" ({motion.place})" if motion and motion.place else ""
    flight = state.robot.flight if state else None
    match step.move.kind:
        case "accepted":
            if flight is not None and flight.purpose == "gate":
                return f"{name}{place} is accepted"
            stops = flight is not None and flight.purpose == "stop"
            return "the wheels are stopped" if stops else "the setpoints are accepted"
        case "rejected":
            return f"the setpoints of {name}{place} are refused by the robot"
        case "failed":
            failed = f"{name}{place} is not done in time"
            return failed if name else "the torques are not borne in time"
        case "fault":
            of = ", ".join(getattr(step.move.event, "of", ()))
            return f"the fault {step.move.word}{of and f' of {of}'} comes up"
        case "answer":
            return f"the operator says '{step.move.word}'"
        case "time":
            return f"{name} is done" if name else "time passes"
        case other:
            return _ALWAYS[other]


_ALWAYS: Mapping[str, str] = {
    "start": "the mission begins",
    "sensors": "",
    "lasting": "sensors show now this and now that",
}


def _consequences(effects: Iterable[Effect], written: Written) -> Iterable[str]:
    for effect in effects:
        match effect:
            case TriggerFired():
                yield f"{effect.phase}: {effect.reason}, so {effect.go}"
            case PhaseChange():
                yield f"{effect.phase} begins"
            case CommandStatus(status="refused"):
                name = written(effect.place, effect.name)
                yield f"{name} ({effect.place}) is refused as {effect.reason}"
            case CommandStatus(status="skipped"):
                name = written(effect.place, effect.name)
                yield f"{name} ({effect.place}) is skipped, {effect.reason}"
            case Fault():
                yield effect.message
            case Ended():
                yield f"the mission has ended: {effect.message}"
            case _:
                pass


def _shown(
    vocabulary: Vocabulary, numbers: Mapping[str, float], words: Mapping[str, str | None]
) -> str:
    """Return the signals that the event requires, as text."""
    parts = [f"{name} = {_quantity(vocabulary, name, value)}" for name, value in numbers.items()]
    parts += [f"{name} = {word or 'unknown'}" for name, word in words.items()]
    return ", ".join(parts)


def _quantity(vocabulary: Vocabulary, name: str, value: float) -> str:
    shown = float(f"{value:.4g}")
    return "unknown" if isnan(value) else format_quantity(shown, vocabulary.dimension(name))
