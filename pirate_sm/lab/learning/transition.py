"""What a step of an environment has done: all that a reward may look at."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple, TypeAlias

Outcome: TypeAlias = Literal["waited", "done", "failed", "refused", "fault"]
"""How a step ended: ``fault`` is a new fault, with the run going on or not."""


class StepMoment(NamedTuple):
    """Where a robot is between two steps.

    Attributes:
        now_s: Mission time.
        states: State of each region of the chart, by the region's name.
        word: Valid word of the detector; empty if unknown.
        signals: Every signal in SI units, by its name; NaN is unknown.
        wheels_m: True place of each wheel along the pipe, which no signal shows.
        rolled_m: True way that the rim of each wheel has rolled since the start, forwards.
    """

    now_s: float
    states: Mapping[str, str]
    word: str
    signals: Mapping[str, float]
    wheels_m: tuple[float, ...]
    rolled_m: tuple[float, ...]

    @property
    def last_wheel_m(self) -> float:
        """Place of the rearmost wheel along the pipe."""
        return min(self.wheels_m)


class Transition(NamedTuple):
    """A step.

    Attributes:
        command: Name of the command; empty for a wait.
        outcome: How the step ended.
        before: The robot before it; ``after``: after it.
        reached: Whether the robot has come to the place that is to be reached.
        ended: Whether the run is over for another reason, such as a fault.
        reach_m: The place that is to be reached by every wheel.
        start_m: Where the last wheel was at the start of the episode.
    """

    command: str
    outcome: Outcome
    before: StepMoment
    after: StepMoment
    reached: bool
    ended: bool
    reach_m: float
    start_m: float
