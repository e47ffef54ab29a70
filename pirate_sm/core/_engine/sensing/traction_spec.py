"""Which signals of slip, normal force and friction a robot has, and what they are made of."""

from __future__ import annotations

from typing import NamedTuple


class WheelTraction(NamedTuple):
    """The signals of one wheel; a number index is -1 where the robot has no such signal.

    Attributes:
        place: Index of the wheel.
        board: Position of the board that reports the wheel.
        slot: Index of its slot.
        speed: Number index of its angular speed.
        torque: Number index of the torque of its motor.
        metres_per_rad: How far ahead it rolls.
        stall_nm: Torque of its motor at full duty when it stands.
        no_load_rad_s: Speed of its motor at full duty without load.
        slip_speed: Target, m/s; positive where the rim is faster than the body.
        slip: Target, slip ratio (thesis eq. 2-1).
        normal_force: Target, N.
        friction: Target, coefficient of kinetic friction, estimated online.
        friction_used: Target, force along the wall over normal force.
        unknown_below_m_s: Body speed below which the slip ratio is unknown.
        slip_above_m_s: Slip speed from which on friction is estimated.
        steady_s: For how long it must have slipped.
    """

    place: int
    board: int
    slot: int
    speed: int
    torque: int
    metres_per_rad: float
    stall_nm: float
    no_load_rad_s: float
    slip_speed: int = -1
    slip: int = -1
    normal_force: int = -1
    friction: int = -1
    friction_used: int = -1
    unknown_below_m_s: float = 0.0
    slip_above_m_s: float = 0.0
    steady_s: float = 0.0

    @property
    def targets(self) -> tuple[int, ...]:
        """Return the number indexes of the wheel's signals."""
        every = (self.slip_speed, self.slip, self.normal_force, self.friction, self.friction_used)
        return tuple(index for index in every if index >= 0)


class TractionSpec(NamedTuple):
    """What slip, normal force and friction of a robot are made of.

    Attributes:
        wheels: Front to rear.
        board: Position of the board of the last wheel, whose frame ends a round of the boards.
        joint_torques: Per wheel the number index of its joint's torque; -1 without a joint.
        mounts: Per wheel the index of the link that its motor sits on.
        masses_kg: Per wheel its mass, with half of its links.
        measured: Number index of the body speed that somebody outside measures; -1 without one.
        averages_s: How long a time that is a mean over.
        delay_s: By how much a frame may be later than a measurement of the same moment.
        robot_speed: Target, the body speed with its fall-back; -1 without one.
        rolling: The wheels that it falls back to.
        agreeing_m_s: How far the speeds of wheels may differ from their median that agree.
        least: For each target, the numbers that it is the least known one of.
    """

    wheels: tuple[WheelTraction, ...]
    board: int
    joint_torques: tuple[int, ...]
    mounts: tuple[int, ...]
    masses_kg: tuple[float, ...]
    measured: int = -1
    averages_s: float = 0.0
    delay_s: float = 0.0
    robot_speed: int = -1
    rolling: tuple[WheelTraction, ...] = ()
    agreeing_m_s: float = 0.0
    least: tuple[tuple[int, tuple[int, ...]], ...] = ()

    @property
    def targets(self) -> tuple[int, ...]:
        """Return the number indexes of all these signals."""
        shared = [index for index, _ in self.least]
        if self.robot_speed >= 0:
            shared.append(self.robot_speed)
        return (*shared, *(index for wheel in self.wheels for index in wheel.targets))
