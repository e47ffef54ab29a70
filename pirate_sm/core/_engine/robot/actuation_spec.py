"""Specifications of slots, of their loops and of what stages write to them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias


class PositionSpec(NamedTuple):
    """A proportional position loop (thesis section 4-2-3): duty = gain * error, then 0.

    ``limit`` is the largest duty cycle, ``unmoved_limit`` that for a joint which it has not moved.
    """

    gain: float
    threshold_rad: float
    least_duty: float
    limit: float
    stall_torque_nm: float
    unmoved_limit: float = 0.0


class VelocitySpec(NamedTuple):
    """A velocity loop: duty = target / no-load speed, plus an integral of the error.

    Attributes:
        gain: Share of the error that each new frame adds to the integral.
        limit: Largest duty cycle used.
        no_load_rad_s: Speed of the motor at full duty without load.
        speed: Number index of the wheel's angular speed.
        radius_m: Of the wheel.
        stall_nm: Torque of the motor at full duty when it stands; 0 where it is not known.
    """

    gain: float
    limit: float
    no_load_rad_s: float
    speed: int
    radius_m: float
    stall_nm: float = 0.0


class TorqueSpec(NamedTuple):
    """A torque loop of a joint behind a self-locking worm and a series spring.

    Attributes:
        gain: Duty cycle per Nm of error.
        dead_nm: Error within which the motor stands.
        within_nm: Error within which the joint counts as settled.
        least_duty: Duty cycle below which the worm would stand still.
        limit: Largest duty cycle used.
        stall_torque_nm: Torque of the motor at full duty when it stands, at the joint.
        torque: Number index of the torque that the joint bears.
    """

    gain: float
    dead_nm: float
    within_nm: float
    least_duty: float
    limit: float
    stall_torque_nm: float
    torque: int


class WheelTorqueSpec(NamedTuple):
    """How a wheel is kept at a torque by its motor's characteristic.

    Attributes:
        stall_torque_nm: Torque at full duty when it stands.
        no_load_rad_s: Speed at full duty without load.
        speed: Number index of the wheel's angular speed.
    """

    stall_torque_nm: float
    no_load_rad_s: float
    speed: int


@dataclass(frozen=True)
class SlotSpec:
    """One setpoint of the wire.

    Attributes:
        angle: Number index of the angle that a position loop or the board's own one controls.
        rate: Number index of that angle's rate; ``torque`` that of the joint's torque; -1 without.
        position: How a duty slot is brought to an angle, None where it cannot be.
        velocity: How a duty slot is kept at a speed, None where it cannot be.
        held_torque: How a joint's duty slot is kept at a torque, None where it cannot be.
        wheel_torque: How a wheel's duty slot is kept at a torque, None where it cannot be.
        self_locking: Whether the motor keeps its place at duty 0, whatever the load.
        low: Least value; ``high`` the largest.
        resolution: Steps of the wire.
        drives: Name of the joint, wheel or roll joint that it drives; empty without one.
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
    held_torque: TorqueSpec | None = None
    wheel_torque: WheelTorqueSpec | None = None
    self_locking: bool = False
    drives: str = ""


class GripSpec(NamedTuple):
    """How hard a part presses; see :class:`pirate_sm.core._model.robot.actuation.Grip`.

    Attributes:
        friction: Of the part's wheels; NaN where it is estimated.
        estimates: Number indexes of the estimates of the part's wheels.
        slip_speeds: Number indexes of the slip speeds of the part's wheels.
        speed: Number index of the body speed that they are counted from; -1 without any.
        angle: Number index of the angle of the apex.
        leg_m: Length of a leg of the part's V.
        weight_n: Of the whole robot; ``wheels`` is how many share it.
        share: By what the torque of eq. 3-25 is multiplied.
        lower_nm_s: How fast the torque is lowered.
    """

    safety: float
    friction: float
    estimates: tuple[int, ...]
    slip_speeds: tuple[int, ...]
    speed: int
    angle: int
    leg_m: float
    weight_n: float
    wheels: int
    share: float
    at_least_nm: float
    at_most_nm: float
    alarm_m_s: float
    lower_nm_s: float


class Write(NamedTuple):
    """The write of a stage to one slot.

    Attributes:
        how: ``set`` a value. ``seek`` an angle by a position loop. ``turn`` at a speed by a
            velocity loop. ``bear`` a torque by a torque loop. ``keep`` what is in force: a
            value, or the loop of another state. ``level``: keep the angle until the inclination
            of the robot is measured, then set the one that brings the part that turns to
            ``value`` against the horizontal.
        value: The value, the angle in rad, the speed in rad/s, or the torque in Nm.
        share_of: Number index of the angle that ``value`` is multiplied by, when the stage begins
            and as that angle changes; -1 where ``value`` is the angle itself.
        assist_nm: Torque by which the wheel would bear its share of the robot's weight in an
            upright pipe; 0 without gravity compensation.
        grip: What the size of the torque of a ``bear`` follows from; None: ``value`` itself.
    """

    slot: int
    how: Literal["set", "seek", "turn", "bear", "keep", "level"]
    value: float
    share_of: int = -1
    assist_nm: float = 0.0
    grip: GripSpec | None = None

    @property
    def turns(self) -> bool:
        """Whether it turns a motor, by a duty, a speed or a torque other than zero."""
        return self.value != 0 and self.how in ("set", "turn", "bear")


StageSpec: TypeAlias = tuple[Write, ...]
