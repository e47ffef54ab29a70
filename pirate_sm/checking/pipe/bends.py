"""Which configurations of a robot bend a part."""

from __future__ import annotations

from math import copysign
from typing import NamedTuple

from pirate_sm.checking.actuation_in_force import Actuated, InForce


class BentPart(NamedTuple):
    """A part that is bent while another one holds.

    Attributes:
        part: Index of the part.
        side: 1 towards side A in normal polarity, -1 away from it.
    """

    part: int
    side: int


class Bends:
    """Finds the configurations of a robot, in one polarity, that bend a part.

    In a bend, joints of a part that is not held have target angles to one side, while another part
    is held. A negative angle turns the body on both sides of the joint to side A. The usual
    actuation of a state counts: no control seeks an angle.
    """

    def __init__(self, force: InForce) -> None:
        self._force, self._robot = force, force.robot
        self._found: dict[int, BentPart | None] = {}
        self._always: dict[int, frozenset[int]] = {}

    def of(self, configuration: int) -> BentPart | None:
        """Return the bend of a configuration; None without one."""
        if configuration not in self._found:
            self._found[configuration] = self._look(configuration)
        return self._found[configuration]

    def always(self, command: int) -> frozenset[int]:
        """Return the parts that a command bends, if it bends one in every case; else none."""
        if command not in self._always:
            table = self._robot.table
            led = {row[command] for n, row in enumerate(table.following) if row[command] != n}
            made = [self.of(each) for each in led]
            parts = frozenset(bend.part for bend in made if bend is not None)
            self._always[command] = parts if None not in made else frozenset()
        return self._always[command]

    def _look(self, configuration: int) -> BentPart | None:
        held, parts = self._robot.held[configuration], self._force.part_of
        sought = {
            BentPart(parts[write.slot], -int(copysign(1, write.value)))
            for write in self._force.writes(Actuated(configuration))
            if write.how == "seek" and write.value and parts.get(write.slot) not in held
        }
        return sought.pop() if held and len(sought) == 1 else None
