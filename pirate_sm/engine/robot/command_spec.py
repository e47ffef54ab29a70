"""A robot's setpoints, and what states and commands make of them."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.engine.robot.criteria import CriterionSpec
from pirate_sm.expressions import Expression


class LoopSpec(NamedTuple):
    """A proportional position loop (thesis section 4-2-3): duty = gain * error, then 0."""

    gain: float
    threshold_rad: float
    least_duty: float
    limit: float
    stall_torque_nm: float


@dataclass(frozen=True)
class SlotSpec:
    """One setpoint of the wire.

    Attributes:
        angle: Number index of the angle that a position loop or the board's own one controls.
        rate: Number index of that angle's rate; ``torque`` that of the joint's torque; -1 without.
        loop: How a duty slot is brought to an angle, None where it cannot be.
        low: Least value; ``high`` the largest.
        resolution: Steps of the wire.
    """

    name: str
    unit: Literal["duty", "angle"]
    low: float
    high: float
    resolution: float
    angle: int = -1
    rate: int = -1
    torque: int = -1
    loop: LoopSpec | None = None


class Write(NamedTuple):
    """What a stage does to a slot: ``set`` a value, ``seek`` an angle by our loop, ``keep``.

    Attributes:
        value: The value, or the angle in rad.
        share_of: Number index of the angle that ``value`` is multiplied by when the stage begins;
            -1 where ``value`` is the angle itself.
    """

    slot: int
    how: Literal["set", "seek", "keep"]
    value: float
    share_of: int = -1


StageSpec: TypeAlias = tuple[Write, ...]


@dataclass(frozen=True)
class PostureSpec:
    """What a command brings the joints to before its states' own actuation.

    Attributes:
        name: Of the posture, for people.
        writes: Its setpoints.
        done: What shows, besides every joint at its angle, that it has been reached.
        within_rad: How far a joint may be from its angle; NaN for the threshold of its loop.
        refuse: Why the command is impossible here; empty where it is not.
    """

    name: str
    writes: StageSpec
    done: CriterionSpec
    within_rad: float = nan
    refuse: str = ""


@dataclass(frozen=True)
class CommandSpec:
    """A command beyond the chart.

    Attributes:
        postures: By the configuration that it leads to, the posture that comes first, or None;
            empty for a command that needs none anywhere.
        asks_for: Condition on the states of the regions; where it holds, the command is unneeded.
        asks_parts: Parts that are held wherever it holds; where there are any, their clamps decide
            whether the command is unneeded.
    """

    name: str
    done: CriterionSpec
    timeout_s: float
    nominal_s: float
    lets_go: bool
    postures: tuple[PostureSpec | None, ...] = ()
    asks_for: Expression | None = None
    asks_parts: frozenset[int] = frozenset()

    def posture(self, configuration: int) -> PostureSpec | None:
        """Return the posture that comes first where the command leads to this configuration."""
        return self.postures[configuration] if self.postures else None
