"""Specifications of slots, loops, writes, postures and commands, with names as indexes."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.engine.robot.criteria import CriterionSpec
from pirate_sm.expressions import Expression


class PositionSpec(NamedTuple):
    """A proportional position loop (thesis section 4-2-3): duty = gain * error, then 0."""

    gain: float
    threshold_rad: float
    least_duty: float
    limit: float
    stall_torque_nm: float


class VelocitySpec(NamedTuple):
    """A velocity loop: duty = target / no-load speed, plus an integral of the error.

    Attributes:
        gain: Share of the error that each new frame adds to the integral.
        limit: Largest duty cycle used.
        no_load_rad_s: Speed of the motor at full duty without load.
        speed: Number index of the wheel's angular speed.
        radius_m: Radius of the wheel.
    """

    gain: float
    limit: float
    no_load_rad_s: float
    speed: int
    radius_m: float


@dataclass(frozen=True)
class SlotSpec:
    """One setpoint of the wire.

    Attributes:
        angle: Number index of the angle that our position loop or the board's controls.
        rate: Number index of the angle's rate; ``torque``: of the joint's torque; -1 without.
        position: Position loop of a duty slot; None without one.
        velocity: Velocity loop of a duty slot; None without one.
        self_locking: Whether the motor holds its position at duty 0 under any load.
        low: Smallest value; ``high``: the largest.
        resolution: Step of the value on the wire.
    """

    name: str
    unit: Literal["duty", "angle"]
    low: float
    high: float
    resolution: float
    angle: int = -1
    rate: int = -1
    torque: int = -1
    position: PositionSpec | None = None
    velocity: VelocitySpec | None = None
    self_locking: bool = False


class Write(NamedTuple):
    """The write of a stage to one slot.

    Attributes:
        how: ``set``: a value. ``seek``: an angle, by a position loop. ``turn``: a speed, by a
            velocity loop. ``keep``: the value or the loop in force.
        value: The value, the angle in rad, or the speed in rad/s.
        share_of: Number index of the angle that ``value`` is multiplied by when the stage begins;
            -1 where ``value`` is the angle itself.
    """

    slot: int
    how: Literal["set", "seek", "turn", "keep"]
    value: float
    share_of: int = -1

    @property
    def turns(self) -> bool:
        """Return whether the write turns a motor: a duty or a speed other than zero."""
        return self.value != 0 and self.how in ("set", "turn")


StageSpec: TypeAlias = tuple[Write, ...]


@dataclass(frozen=True)
class PostureSpec:
    """A posture: joint angles that a command reaches before the actuation of its states.

    Attributes:
        name: Name of the posture, for messages.
        writes: Its setpoints.
        done: Criterion of completion, besides every joint at its angle.
        within_rad: Tolerance of the angles; NaN for the threshold of the position loop.
        refuse: Why the command is impossible here; empty if it is possible.
    """

    name: str
    writes: StageSpec
    done: CriterionSpec
    within_rad: float = nan
    refuse: str = ""


@dataclass(frozen=True)
class CommandSpec:
    """The properties of a command that the chart does not define.

    Attributes:
        postures: The posture for each target configuration, or None; empty for a command without
            postures.
        asks_for: Condition on the states of the regions. Where it holds, the command is unneeded.
        asks_parts: Parts that are held wherever ``asks_for`` holds. If there are any, the command
            is unneeded only while their clamps are confirmed.
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
        """Return the posture that precedes a change to this configuration, or None."""
        return self.postures[configuration] if self.postures else None
