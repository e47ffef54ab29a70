"""Follow how a robot's roll joint turns its parts, and which relaxed parts stay wound."""

from __future__ import annotations

from math import isnan, nan, pi, remainder
from typing import NamedTuple

from pirate_sm.checking.actuation_in_force import Actuated, InForce
from pirate_sm.core.robot import Write

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

        A self-locking worm that is not driven any more stays as it is: the part goes on pressing on
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
