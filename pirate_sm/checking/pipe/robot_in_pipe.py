"""A robot in a pipe: its length, forces on walls, its weight, how its roll joint turns it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from math import asin, inf, isnan, nan, pi, remainder, sqrt
from typing import NamedTuple

from pirate_sm.checking.actuation_in_force import Actuated, InForce
from pirate_sm.core.geometry import (
    BRANCH,
    GRAVITY_M_S2,
    WHEELS_SHARE,
    Piece,
    Route,
    RouteJoint,
    Vector,
    dot,
    port_of,
    press_n,
    span_m,
    tilted_up,
)
from pirate_sm.core.models import FrictionStretch, Link, Pipe, Profile
from pirate_sm.core.robot import RobotSpec, Write, torque_nm

_NEAR_M = 1e-6
"""How far on either side of a patch's edge a wheel is looked at."""


@dataclass(frozen=True)
class Fit:
    """A robot in a pipe.

    Attributes:
        profile: The robot.
        robot: The engine's specification of the robot, in the polarity of the mission.
        pipe: The pipe.
    """

    profile: Profile
    robot: RobotSpec
    pipe: Pipe

    @cached_property
    def force(self) -> InForce:
        """Return what the robot's states write."""
        return InForce(self.profile, self.robot)

    @cached_property
    def route(self) -> Route:
        """Return the route through the pipe."""
        return self.pipe.route()

    def mouth_m(self, tee: RouteJoint) -> float:
        """Return the inner diameter of the branch of a tee, m."""
        for run in self.route.network.runs.values():
            for port, diameter_m in zip(
                (run.begins, run.ends), (run.diameters_m[0], run.diameters_m[-1]), strict=True
            ):
                if port_of(port) == (tee.junction, BRANCH):
                    return diameter_m
        return 0.0

    def walls_end(self, joint: RouteJoint) -> tuple[float, float]:
        """Return between which arc lengths a joint leaves a robot no plain walls, m."""
        before_m, behind_m = joint.before_m, joint.behind_m
        if joint.kind == "tee" and not joint.turn_rad:
            before_m = behind_m = self.mouth_m(joint) / 2
        return joint.arc_m - before_m, joint.arc_m + behind_m

    def height_m(self, diameter_m: float) -> float:
        """Return the height h of a V that is clamped in an inner diameter, m (eq. 3-2)."""
        return diameter_m - 2 * self.profile.body.wheel_radius

    @property
    def stretched_m(self) -> float:
        """Return the length of the straight robot from the first wheel to the last, m."""
        return sum(link.length for link in self.profile.body.links)

    def clamped_m(self, diameter_m: float) -> float:
        """Return the length of the robot with adjacent wheels on opposite walls, m."""
        height_m = self.height_m(diameter_m)
        return sum(span_m(link.length, height_m) for link in self._links)

    @property
    def weight_n(self) -> float:
        """Return the weight of the whole robot, N."""
        return self.profile.body.mass_kg * GRAVITY_M_S2

    @property
    def friction(self) -> float:
        """Return the static friction coefficient."""
        friction = self.pipe.friction or self.profile.simulation.friction
        return friction.static

    def ups(self, until_s: float) -> tuple[Vector, ...]:
        """Return the directions against gravity at the beginning, and once the pipe has turned.

        Args:
            until_s: When the mission ends at the latest; how far the pipe turns until then counts.
        """
        turns, pipe = self.pipe.turns, self.pipe
        if turns is None or until_s <= turns.from_s:
            return (self.route.up,)
        share = min((until_s - turns.from_s) / (turns.to - turns.from_s), 1.0)
        turned = tilted_up(pipe.tilt + share * (turns.tilt - pipe.tilt), pipe.uphill)
        return self.route.up, turned

    def pull_n(self, piece: Piece, up: Vector | None = None) -> tuple[float, float]:
        """Return the weight's components along a piece of pipe and against its walls, N.

        Args:
            piece: The piece of pipe.
            up: The direction against gravity; None for that of the beginning.
        """
        slope = dot(up or self.route.up, piece.frame.ahead)
        return abs(slope) * self.weight_n, sqrt(max(1 - slope**2, 0.0)) * self.weight_n

    def torques_nm(
        self, part: int, at: Actuated, diameter_m: float, slope: float = 0.0
    ) -> tuple[float, float]:
        """Return with which torque a held part's apex presses, and how much it may be raised to.

        Both are infinite if the states set none. They differ where the control has a grip, which
        follows the slope and the friction, and is raised where a wheel is seen to slip.

        Args:
            part: Index of the part.
            at: What is active.
            diameter_m: Inner diameter of the pipe there.
            slope: Sine of the pipe's tilt there.
        """
        joint = self.profile.body.parts[self.robot.parts[part]].apex
        found, slots = [(inf, inf)], self.profile.slots
        for write in self.force.writes(at):
            slot = slots[write.slot]
            stall = self.profile.motors[slot.motor].stall_torque
            if slot.joint == joint and write.how == "set" and stall is not None:
                found.append((abs(write.value) * stall, abs(write.value) * stall))
            elif slot.joint == joint and write.how == "bear":
                found.append(self._borne_nm(write, diameter_m, slope))
        return min(found)

    def _borne_nm(self, write: Write, diameter_m: float, slope: float) -> tuple[float, float]:
        """Return the same for an apex that is kept at a torque."""
        grip = write.grip
        if grip is None:
            return abs(write.value), abs(write.value)
        friction = self.friction if isnan(grip.friction) else grip.friction
        apex_rad = 2 * asin(min(self.height_m(diameter_m) / grip.leg_m, 1.0))
        needed = torque_nm(grip, friction, apex_rad, asin(slope))
        return min(max(needed, grip.at_least_nm), grip.at_most_nm), grip.at_most_nm

    def press_n(self, part: int, torque_nm: float, diameter_m: float) -> float:
        """Return the sum of the normal forces of a held part whose apex bears a torque, N."""
        leg_m = min(self.profile.body.legs_m(self.robot.parts[part]))
        return press_n(torque_nm, leg_m, self.height_m(diameter_m))

    def frictions(
        self, parts: Iterable[int], firsts: tuple[float, float], diameter_m: float
    ) -> list[list[float]]:
        """Return the static friction that each held part finds, at all places that matter.

        A part's apex presses twice as hard as the wheels next to it (eq. 3-3), and each wheel has
        the friction of the patch that it is on.

        Args:
            parts: Indexes of the held parts.
            firsts: Between which arc lengths the first wheel of the clamped robot may be.
            diameter_m: Inner diameter of the pipe there.

        Returns:
            For each place one friction for each part.
        """
        height_m = self.height_m(diameter_m)
        behind = [0.0, *accumulate(span_m(each.length, height_m) for each in self._links)]
        edges = {edge for patch in self._patches for edge in (patch.from_m, patch.to_m)}
        low, high = firsts
        near = {
            edge + way + back for edge in edges for way in (-_NEAR_M, _NEAR_M) for back in behind
        }
        places = [low, high, *(each for each in sorted(near) if low < each < high)]
        apexes = [self._apex_wheel(part) for part in parts]
        return [[self._mean_friction(place, behind, apex) for apex in apexes] for place in places]

    @cached_property
    def _patches(self) -> tuple[FrictionStretch, ...]:
        return self.pipe.stretches(self.route)

    @property
    def _links(self) -> tuple[Link, ...]:
        return self.profile.body.links

    def _apex_wheel(self, part: int) -> int:
        """Return the index of the wheel at the apex of a part."""
        body = self.profile.body
        joint = body.parts[self.robot.parts[part]].apex
        wheel = next(each.wheel for each in body.joints if each.name == joint)
        return [each.name for each in body.wheels].index(wheel)

    def _mean_friction(self, first_m: float, behind: Sequence[float], apex: int) -> float:
        before, at, after = (self._friction_at(first_m - m) for m in behind[apex - 1 : apex + 2])
        return (before + 2 * at + after) / WHEELS_SHARE

    def _friction_at(self, place_m: float) -> float:
        for patch in self._patches:
            if patch.from_m <= place_m < patch.to_m:
                return patch.friction.static
        return self.friction


# --- roll joint ----------------------------------------------------------------------------------


QUARTER_RAD = pi / 2
_DIGITS = 6


class PartRolls(NamedTuple):
    """By how many quarter turns the parts are rolled against the robot as it starts.

    The sense is that of rolls in a pipe: a positive one turns side A up where the pipe is flat.

    Attributes:
        ahead: The parts ahead of the roll joint.
        behind: The parts behind it.
    """

    ahead: float = 0.0
    behind: float = 0.0

    @property
    def joint(self) -> float:
        """Return the angle of the roll joint in quarter turns, within ±2."""
        return remainder(self.ahead - self.behind, 4.0)

    def turned(self, quarters: float, *, ahead: bool) -> PartRolls:
        """Return the rolls after the joint has turned, and with it the parts ahead or behind."""
        if ahead:
            return self._replace(ahead=round(remainder(self.ahead + quarters, 4.0), _DIGITS))
        return self._replace(behind=round(remainder(self.behind - quarters, 4.0), _DIGITS))


class RollJoint:
    """The roll joint of a robot.

    A positive angle of the joint rolls what is ahead of it like a positive roll in a pipe, against
    what is behind: so do the simulators, and the profile's 90 deg for a turn to the right.

    Attributes:
        link: Index of the link that it turns; -1 without a roll joint.
    """

    def __init__(self, force: InForce) -> None:
        self._force, robot = force, force.robot
        self._robot, body = robot, force.profile.body
        rolls = [number for number, link in enumerate(body.links) if link.roll is not None]
        self.link = rolls[0] if len(rolls) == 1 else -1
        self._slots = {n for n, slot in enumerate(force.profile.slots) if slot.roll}
        self._ahead = frozenset(
            robot.parts.index(wheel.part)
            for number, wheel in enumerate(body.wheels)
            if number <= self.link
        )
        self._aims: dict[int, float | None] = {}

    def is_ahead(self, part: int) -> bool:
        """Return whether a part is ahead of the joint."""
        return part in self._ahead

    def roll(self, rolls: PartRolls, part: int) -> float:
        """Return the roll of a part in quarter turns."""
        return rolls.ahead if self.is_ahead(part) else rolls.behind

    def aim(self, configuration: int) -> float | None:
        """Return the angle that a configuration asks for, in quarter turns.

        None: the joint keeps its angle. NaN: an angle that is unknown before the mission runs.
        """
        if configuration not in self._aims:
            self._aims[configuration] = self._aim(configuration)
        return self._aims[configuration]

    def _aim(self, configuration: int) -> float | None:
        write = self._asked(configuration)
        if write is None:
            return None
        plain = write.how == "set" and write.share_of < 0
        return round(write.value / QUARTER_RAD, _DIGITS) if plain else nan

    def _asked(self, configuration: int) -> Write | None:
        """Return what a configuration writes to the joint; None if it keeps its angle."""
        writes = self._force.last_writes(Actuated(configuration))
        return next((w for w in writes if w.slot in self._slots and w.how != "keep"), None)

    def commands_to(self, joint: float) -> tuple[str, ...]:
        """Return the commands that turn the joint to an angle, in quarter turns, in every case."""
        table = self._robot.table
        led: dict[str, set[float | None]] = {}
        for before, row in enumerate(table.following):
            for command, after in enumerate(row):
                if after != before:
                    aim = self.aim(after) if self.turns(before, after) else None
                    led.setdefault(table.commands[command], set()).add(aim)
        return tuple(name for name, aims in led.items() if aims == {joint})

    def turns(self, before: int, after: int) -> bool:
        """Return whether the joint is asked for another angle after a command than before."""
        asked = self._asked(after)
        return asked is not None and asked != self._asked(before)

    def turning(self, configuration: int) -> frozenset[int]:
        """Return the parts that turn if the joint turns: those on the side that does not hold.

        None turn where both sides hold or neither does.
        """
        held, parts = self._robot.held[configuration], range(len(self._robot.parts))
        ahead = frozenset(part for part in parts if self.is_ahead(part))
        behind = frozenset(parts) - ahead
        if held & behind and not held & ahead:
            return ahead
        return behind if held & ahead and not held & behind else frozenset()

    def after(self, rolls: PartRolls | None, before: int, after: int) -> PartRolls | None:
        """Return the rolls after a command; None if they are unknown.

        Args:
            rolls: Those before it.
            before: The configuration before it.
            after: The configuration after it.
        """
        aim, held = self.aim(after), self._robot.held
        if rolls is None or (held[before] and not held[after]):
            return None  # a loose robot may roll either way in a round pipe
        if aim is None or aim == rolls.joint or not self.turns(before, after):
            return rolls
        turning = self.turning(after)
        if isnan(aim) or not turning:
            return None
        return rolls.turned(aim - rolls.joint, ahead=min(turning) in self._ahead)

    def wound(self, wound: frozenset[int], before: int, command: int, after: int) -> frozenset[int]:
        """Return the parts that are relaxed with their worms wound, after a command.

        A self-locking worm that is not driven any more stays as it is: the part keeps pressing on
        the walls until its joints are brought to an angle, or clamp again.

        Args:
            wound: Those before it.
            before: The configuration before it.
            command: Index of the command.
            after: The configuration after it.
        """
        held = self._robot.held
        left = {part for part in held[before] - held[after] if self._locks(part)}
        if not wound and not left:
            return wound
        posture = self._robot.commands[command].posture(after)
        writes = [*self._force.writes(Actuated(after)), *(posture.writes if posture else ())]
        parts = self._force.part_of
        sought = {parts[w.slot] for w in writes if w.how == "seek" and w.slot in parts}
        return frozenset((wound | left) - held[after] - sought)

    def _locks(self, part: int) -> bool:
        own = (slot for slot, its in self._force.part_of.items() if its == part)
        return any(self._robot.slots[slot].self_locking for slot in own)
