"""What a robot's states write under the active control, and whether its motors can do it.

A control actuates the same states in another way: its wheels may be slower, its clamps weaker. The
exploration and the course of a mission know which control is active at each of their points.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from math import inf
from typing import NamedTuple

from pirate_sm.core.models import Motor, Profile
from pirate_sm.core.robot import (
    CriterionSpec,
    RobotSpec,
    TorqueBorne,
    WheelTurning,
    Write,
)

OVERSHOOT = 2.0
"""Largest speed of what is kept at a speed, as a share of that speed [decided]. Its loop learns
while the wheel is still at rest, and wheels push each other: in the simulator one that is kept at
20 mm/s turned 1.93 times as fast for a moment, and the robot 1.2 times."""


class Actuated(NamedTuple):
    """A configuration and the control by which its states are actuated, as indexes."""

    configuration: int
    control: int = 0


def under(robot: RobotSpec, control: int) -> str:
    """Return ", under the control 'NAME'" for messages; empty for the usual one."""
    name = robot.controls[control].name
    return f", under the control '{name}'" if name else ""


@dataclass(frozen=True)
class InForce:
    """The actuation of a robot, under any of its controls.

    Attributes:
        profile: The robot.
        robot: The engine's specification of it, in one polarity.
    """

    profile: Profile
    robot: RobotSpec

    @cached_property
    def part_of(self) -> Mapping[int, int]:
        """Return the part of the joint that each slot bends, by their indexes."""
        parts, joints = self.robot.parts, self.profile.body.joints
        own = {joint.name: parts.index(joint.part) for joint in joints}
        slots = enumerate(self.profile.slots)
        return {number: own[slot.joint] for number, slot in slots if slot.joint}

    def writes(self, at: Actuated, slot: int | None = None) -> Iterator[Write]:
        """Yield what all stages write, to one slot or to all."""
        written = self._written[at.control]
        for region, state in enumerate(self.robot.table.configurations[at.configuration]):
            yield from written[region][state].get(slot, ())

    @cached_property
    def _written(self) -> Sequence[Sequence[Mapping[str, Mapping[int | None, Sequence[Write]]]]]:
        """Return what each state of each region writes, to each slot and to all (None)."""
        return [
            [
                {state: _by_slot(stages) for state, stages in region.items()}
                for region in control.actuation
            ]
            for control in self.robot.controls
        ]

    def last_writes(self, at: Actuated) -> Iterator[Write]:
        """Yield what the last stage of each state writes."""
        actuation = self.robot.controls[at.control].actuation
        for region, state in enumerate(self.robot.table.configurations[at.configuration]):
            yield from actuation[region][state][-1]

    def last_of(self, at: Actuated, slot: int) -> Write | None:
        """Return what the last stages write to a slot; None if nothing."""
        return next((write for write in self.last_writes(at) if write.slot == slot), None)

    def may_follow(self, at: Actuated, slot: int) -> set[Write | None]:
        """Return what a slot may still follow: its last write, or those of states before it.

        A command that counts as done when it is accepted does not wait until the slot has come to
        what the command asks for; neither does one that asks the slot for nothing new.
        """
        found, waiting, seen = set[Write | None](), [at], {at}
        while waiting:
            here = waiting.pop()
            now = self.last_of(here, slot)
            found.add(now)
            for before, waits in self._before[here.configuration]:
                was = here._replace(configuration=before)
                if was not in seen and not (waits and self.last_of(was, slot) != now):
                    seen.add(was)
                    waiting.append(was)
        return found

    @cached_property
    def _before(self) -> Mapping[int, Set[tuple[int, bool]]]:
        """The configurations before each one, and whether the command waits for what it asks."""
        found = defaultdict[int, set[tuple[int, bool]]](set)
        waits = [each.proof == "sensor" for each in self.robot.commands]
        for before, row in enumerate(self.robot.table.following):
            for command, after in enumerate(row):
                if after != before:
                    found[after].add((before, waits[command]))
        return found

    def most_nm(self, at: Actuated, slot: int) -> float:
        """Return the largest torque that a slot's motor gives; infinite where that is not known.

        A torque loop gives what it is asked for, so a criterion is met there by its own torque.
        """
        spec, motor = self.robot.slots[slot], self._motors[slot]
        if motor.stall_torque is None:
            return inf
        most = 0.0
        for write in self.writes(at, slot):
            match write.how:
                case "set":
                    most = max(most, abs(write.value))
                case "seek":
                    most = max(most, spec.position.limit if spec.position else 1.0)
                case "turn":
                    most = max(most, spec.velocity.limit if spec.velocity else 1.0)
                case "bear":
                    return inf
                case "keep" | "level":
                    most = 1.0  # what another state has written
        return most * motor.stall_torque

    def winds_s(self, control: int) -> float:
        """Return how long a motor takes at least to wind its spring to a torque of a control, s."""
        least_s = 0.0
        for region in self.robot.controls[control].actuation:
            for stages in region.values():
                for write in (write for stage in stages for write in stage if write.how == "bear"):
                    motor = self._motors[write.slot]
                    if motor.stiffness and motor.no_load_speed:
                        wound_rad = abs(write.value) / motor.stiffness
                        least_s = max(least_s, wound_rad / motor.no_load_speed)
        return least_s

    def most_rad_s(self, at: Actuated, slot: int) -> float:
        """Return the largest speed that a wheel comes to by itself, rad/s; infinite if unknown."""
        no_load = self._motors[slot].no_load_speed or inf
        return max((_rad_s(write, no_load) for write in self.writes(at, slot)), default=0.0)

    def fastest_m_s(self, at: Actuated) -> float:
        """Return the largest speed of a robot whose wheels are kept at speeds, m/s.

        It is infinite where no wheel is, or one is driven otherwise: nothing keeps that one from
        the speed without load.
        """
        speeds = [0.0]
        for wheel in self.robot.wheels:
            for write in self.last_writes(at):
                if write.slot == wheel.slot and (write.turns or write.how == "keep"):
                    kept = write.how == "turn"
                    speeds.append(abs(write.value * wheel.metres_per_rad) if kept else inf)
        return max(speeds) * OVERSHOOT or inf

    @cached_property
    def _motors(self) -> Sequence[Motor]:
        return [self.profile.motors[slot.motor] for slot in self.profile.slots]


def _by_slot(stages: Sequence[Sequence[Write]]) -> Mapping[int | None, Sequence[Write]]:
    """Return the writes of all stages, by their slot and all together (None)."""
    found = defaultdict[int | None, list[Write]](list)
    for write in chain.from_iterable(stages):
        found[write.slot].append(write)
        found[None].append(write)
    return found


def _rad_s(write: Write, no_load: float) -> float:
    """Return how fast a motor without load turns by a write, rad/s."""
    match write.how:
        case "set":
            return abs(write.value) * no_load if write.value else 0.0
        case "turn":
            return abs(write.value) * OVERSHOOT
        case "seek" | "keep" | "level":
            return no_load
        case "bear":
            return no_load if write.value else 0.0


def too_strong(force: InForce, done: CriterionSpec, led: Sequence[Actuated]) -> str:
    """Return why a joint cannot bear the required torque; empty if it can.

    Args:
        force: What is active.
        done: The criterion.
        led: Where the command leads to; one that suffices is enough.
    """
    for load in done.asked(TorqueBorne) if led else ():
        if load.slot < 0:
            continue
        most, slot = max(force.most_nm(at, load.slot) for at in led), load.slot
        if most <= load.least_nm:
            there = under(force.robot, led[0].control)
            return (
                f"its motor gives '{force.profile.slots[slot].joint}' at most {most:.3g} Nm there,"
                f" and more than {load.least_nm:.3g} Nm are asked for{there}"
            )
    return ""


def too_slow(force: InForce, done: CriterionSpec, led: Sequence[Actuated]) -> str:
    """Return why no wheel can reach the required speed; empty if one can.

    The arguments are those of :func:`too_strong`.
    """
    for asked in done.asked(WheelTurning):
        driven = [(at, slot) for at in led for slot, _ in asked.wheels]
        if not driven or any(force.most_rad_s(*each) > asked.above for each in driven):
            continue
        most = max(force.most_rad_s(*each) for each in driven)
        if most == 0:
            return "no wheel is driven in the states that it leads to"
        there = under(force.robot, led[0].control)
        return (
            f"wheels turn with at most {most:.3g} rad/s there, {asked.above:.3g} rad/s are asked"
            f" for{there}"
        )
    return ""
