"""The motors, readings and lights of a robot that views show, read from its profile."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from pirate_sm.core.expressions import tree
from pirate_sm.core.models import Profile, Slot
from pirate_sm.core.models import signals as kinds
from pirate_sm.core.robot import RobotSpec


class MotorReadings(NamedTuple):
    """A motor with what is measured of it; names of signals, empty where nothing is.

    Attributes:
        name: Of the joint, wheel or roll joint.
        value: What it moves: an angle, or a wheel's speed.
        limit: Largest magnitude of that; 0 where there is none.
        torque: Torque; ``current`` the current, and ``stall_a`` that at stall, 0 where unknown.
        slot: Index of its setpoint; -1 without one.
        heat: Indexes of the fault rules that look at its current alone.
    """

    name: str
    value: str
    limit: float
    torque: str
    current: str
    stall_a: float
    slot: int
    heat: tuple[int, ...]


class ShownReading(NamedTuple):
    """Another signal worth a look, and how it is written."""

    label: str
    signal: str
    kind: str


@dataclass(frozen=True)
class Anatomy:
    """All of it, from the front to the rear.

    Attributes:
        joints: Bend joints; ``rolls`` the roll joints; ``wheels`` the wheels.
        readings: Attitude, diameters, odometry and speed, as far as there are any.
        lights: Slot index of each light, and whether it shines forward.
        wheel_parts: Per wheel the index of its part; -1 without.
    """

    joints: tuple[MotorReadings, ...]
    rolls: tuple[MotorReadings, ...]
    wheels: tuple[MotorReadings, ...]
    readings: tuple[ShownReading, ...]
    lights: tuple[tuple[int, bool], ...]
    wheel_parts: tuple[int, ...]
    joint_at: tuple[str, ...]
    wheel_radius_m: float
    half_thickness_m: float

    @property
    def motors(self) -> tuple[MotorReadings, ...]:
        """Return every motor that something is measured of."""
        return (*self.joints, *self.rolls, *self.wheels)

    @property
    def followed(self) -> tuple[str, ...]:
        """Return the signals whose trend is shown."""
        return tuple(
            {each for motor in self.motors for each in (motor.current, motor.value) if each}
        )

    @property
    def slots(self) -> tuple[int, ...]:
        """Return the slots of the motors."""
        return tuple(motor.slot for motor in self.motors if motor.slot >= 0)


def anatomy_of(profile: Profile, robot: RobotSpec) -> Anatomy:
    """Return the anatomy of a robot."""
    body, seeker = profile.body, _Seeker(profile, robot)
    joint_of = {joint.wheel: joint.name for joint in body.joints}
    return Anatomy(
        joints=tuple(
            seeker.motor(each.name, each.name, each.end_stop, each.torque or "", joint=each.name)
            for each in body.joints
        ),
        rolls=tuple(
            seeker.motor(each.roll, each.roll, 0.0, "", roll=each.roll)
            for each in body.links
            if each.roll
        ),
        wheels=tuple(
            seeker.motor(each.name, each.speed, 0.0, "", wheel=each.name) for each in body.wheels
        ),
        readings=tuple(_readings(profile)),
        lights=tuple(seeker.lights()),
        wheel_parts=tuple(
            robot.parts.index(each.part) if each.part in robot.parts else -1 for each in body.wheels
        ),
        joint_at=tuple(joint_of.get(each.name, "") for each in body.wheels),
        wheel_radius_m=body.wheel_radius,
        half_thickness_m=body.body_half_thickness,
    )


_WRITTEN: Mapping[type, str] = {
    kinds.RollOf: "angle",
    kinds.PitchOf: "angle",
    kinds.DiameterOf: "length",
    kinds.OdometryOf: "distance",
    kinds.SpeedOf: "speed",
    kinds.NormOf: "acceleration",
}
"""How each kind of derived signal is written that is shown as a number, in the order shown."""


def _readings(profile: Profile) -> Iterator[ShownReading]:
    """Yield the derived signals that are shown as a number, kind after kind."""
    for kind, written in _WRITTEN.items():
        for name, derived in profile.derived.items():
            if isinstance(derived, kind):
                of = derived.diameter_of if isinstance(derived, kinds.DiameterOf) else ""
                yield ShownReading(f"⌀ {of}" if of else name, name, written)


class _Seeker:
    """Finds what belongs to a motor."""

    def __init__(self, profile: Profile, robot: RobotSpec) -> None:
        self._profile = profile
        self._slots = profile.slots
        self._senses = {
            (channel.slot, channel.senses): channel.signal or ""
            for board in profile.boards
            for channel in board.channels
            if board.fitted and board.channels_fitted
        }
        self._heat: dict[str, list[int]] = {}
        for index, rule in enumerate(robot.faults):
            names = {
                node.name for node in tree.walk(rule.when.tree) if isinstance(node, tree.Signal)
            }
            if len(names) == 1 and rule.held_s > 0:
                self._heat.setdefault(names.pop(), []).append(index)

    def motor(
        self, name: str, value: str, limit: float, torque: str, **drives: str
    ) -> MotorReadings:
        """Return the motor behind what is driven."""
        ((key, driven),) = drives.items()
        found = [n for n, slot in enumerate(self._slots) if getattr(slot, key) == driven]
        if not found:
            return MotorReadings(name, value, limit, torque, "", 0.0, -1, ())
        slot = self._slots[found[0]]
        kind = self._profile.motors[slot.motor]
        current = self._senses.get((slot.name, "current"), "")
        if not limit:
            limit = slot.limit or (0.0 if slot.unit == "angle" else kind.no_load_speed or 0.0)
        heat = tuple(self._heat.get(current, ()))
        torque = torque or self._profile.derived_by(kinds.TorqueOf, slot=slot.name)
        return MotorReadings(
            name, value, limit, torque, current, kind.stall_current or 0.0, found[0], heat
        )

    def lights(self) -> Iterator[tuple[int, bool]]:
        """Yield each light; one on the first half of the boards shines forward."""
        number, boards = 0, self._profile.boards
        for place, board in enumerate(boards):
            for slot in board.slots:
                if self._shines(slot):
                    yield number, 2 * place < len(boards)
                number += 1

    def _shines(self, slot: Slot) -> bool:
        return self._profile.motors[slot.motor].kind == "light"
