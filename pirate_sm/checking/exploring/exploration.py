"""All that can happen to a mission, as nodes and the steps between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from pirate_sm.checking.exploring.answers import BranchAnswers, StepAnswers
from pirate_sm.checking.exploring.possible_events import PossibleEvent
from pirate_sm.checking.exploring.state_keys import fewest_mishaps
from pirate_sm.engine.mission.program import Program
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect, TriggerFired

BEGINS = "\0begins "
"""Before the place of a call, in a line of the log that tells that its terms are met."""

MISHAPS = frozenset({"rejected", "failed", "fault"})
"""Kinds of moves that nobody plans for."""

WITHIN = "within"
"""The name under which the limit of a wait stands among its triggers."""


class ExploredState(NamedTuple):
    """A state of the engine, reached for the first time.

    Attributes:
        step: Index of the step that led here.
        sure: Whether it is reached without what the check cannot decide.
    """

    state: EngineState
    now: float
    step: int
    sure: bool

    @property
    def over(self) -> bool:
        """Return whether the run is ending here."""
        return self.state.mission.ended or self.state.mission.ending is not None


class ExploredStep(NamedTuple):
    """Something happened.

    Attributes:
        source: Index of the node before, -1 before the start.
        target: Index of the node after it.
        effects: What followed, without setpoints.
        moment: What sensors must have shown.
    """

    source: int
    target: int
    move: PossibleEvent
    effects: tuple[Effect, ...]
    moment: StepAnswers
    sure: bool

    @property
    def in_vain(self) -> bool:
        """Return whether a wait has lasted too long."""
        return any(isinstance(e, TriggerFired) and e.trigger == WITHIN for e in self.effects)

    @property
    def went_wrong(self) -> bool:
        """Return whether it is a mishap, or a wait that has lasted too long."""
        return self.move.kind in MISHAPS or self.in_vain


@dataclass
class Exploration:
    """All that can happen.

    Attributes:
        complete: False when there was too much of it.
        work: How much of ``MOST_WORK`` it took.
        branches: By the place of each branch what its condition has been.
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
        """Return the shortest course of events that ends with this step, from the start on."""
        found = []
        while step >= 0:
            found.append(self.steps[step])
            source = self.steps[step].source
            step = self.nodes[source].step if source >= 0 else -1
        return found[::-1]

    def mishaps(self, step: int) -> int:
        """Return how many things must go wrong, at least, before and in this step."""
        if not self._mishaps:
            self._mishaps = fewest_mishaps([(e.source, e.target, e.went_wrong) for e in self.steps])
        here = self.steps[step]
        before = self._mishaps[here.source] if here.source >= 0 else 0
        return before + here.went_wrong

    def is_playable(self, step: int) -> bool:
        """Return whether a course of single events, one after the other, leads there."""
        return all(each.move.kind != "lasting" for each in self.path(step))
