"""What a step is worth; each reward is a function of the transition, so that it can be replaced.

The numbers are decided here: they order courses of the robot and measure nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from statistics import fmean
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import meant

# --- transitions ---------------------------------------------------------------------------------


Outcome: TypeAlias = Literal["waited", "done", "failed", "refused", "fault"]
"""How a step ended: ``fault`` is a new fault, whether the run continues or not."""


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


# --- rewards -------------------------------------------------------------------------------------


Reward: TypeAlias = Callable[[Transition], float]

PER_COMMAND = 0.02
"""What a command costs; the bend of the thesis takes 16, which is less than reaching is worth."""

PER_SECOND = 0.001
"""What a second costs, so that an agent that waits forever is worse off than one that arrives."""

PER_METRE = 1.0
"""What a metre of slip costs, averaged over the wheels."""


def reach(step: Transition) -> float:
    """Return 1 when the place is reached, and -1 when the run has ended otherwise; time costs."""
    time_s = step.after.now_s - step.before.now_s
    return float(step.reached) - float(step.ended) - PER_SECOND * time_s


def progress(step: Transition) -> float:
    """Return what :func:`reach` does, and the share of the way that the robot has come forward.

    Over an episode the shares add up to about 1, and going back takes them away again. An agent
    that does not know where it is can take going to and fro for progress.
    """
    way_m = max(step.reach_m - step.start_m, 1e-9)
    return reach(step) + (fmean(step.after.wheels_m) - fmean(step.before.wheels_m)) / way_m


def least_commands(step: Transition) -> float:
    """Return what :func:`reach` does, less a cost of each command."""
    return reach(step) - (PER_COMMAND if step.command else 0.0)


def least_slip(step: Transition) -> float:
    """Return what :func:`reach` does, less a cost of slip: rims roll, wheels do not go."""
    before, after = step.before, step.after
    rolled = (b - a for a, b in zip(before.rolled_m, after.rolled_m, strict=True))
    gone = (b - a for a, b in zip(before.wheels_m, after.wheels_m, strict=True))
    slip_m = fmean(abs(r - g) for r, g in zip(rolled, gone, strict=True))
    return reach(step) - PER_METRE * slip_m


REWARDS: Mapping[str, Reward] = {
    "reach": reach,
    "progress": progress,
    "least_commands": least_commands,
    "least_slip": least_slip,
}
"""The rewards that can be given by name."""


def reward_of(reward: str | Reward) -> Reward:
    """Return a reward that may be given by its name.

    Raises:
        UsageError: There is no such reward.
    """
    if callable(reward):
        return reward
    if reward not in REWARDS:
        raise UsageError(f"there is no reward {reward!r}: {meant(str(reward), sorted(REWARDS))}")
    return REWARDS[reward]
