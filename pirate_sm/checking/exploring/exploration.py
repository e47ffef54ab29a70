"""The result of an exploration: states of a mission and the steps between them."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pirate_sm.checking.exploring.answers import BranchAnswers, StepAnswers
from pirate_sm.checking.exploring.possible_events import PossibleEvent
from pirate_sm.core.effects import Effect, TriggerFired
from pirate_sm.core.engine import EngineState
from pirate_sm.core.program import Program
from pirate_sm.core.robot import RobotSpec

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
    """

    program: Program
    robot: RobotSpec
    nodes: list[ExploredState] = field(default_factory=list)
    steps: list[ExploredStep] = field(default_factory=list)
    complete: bool = True
    work: float = 0.0
    branches: Mapping[str, set[BranchAnswers]] = field(default_factory=dict)
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
