"""An index of an exploration by places in the mission's files."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TypeAlias

from pirate_sm.checking.actuation_in_force import Actuated
from pirate_sm.checking.exploring.exploration import BEGINS, Exploration, ExploredStep
from pirate_sm.core.effects import (
    CommandStatus,
    Ended,
    Fault,
    Log,
    PhaseChange,
    TriggerFired,
    WaitArmed,
)
from pirate_sm.core.program import ROUND_AND_ROUND
from pirate_sm.core.robot import rules

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
        actuated: In which configurations it began, each with the control in force.
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
            case Fault(code=rules.CODE):
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
