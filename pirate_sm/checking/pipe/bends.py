"""Which configurations of a robot bend a part."""

from __future__ import annotations

from math import copysign
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model.profile import Profile


class Bend(NamedTuple):
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

    def __init__(self, robot: RobotSpec, profile: Profile) -> None:
        self._robot = robot
        parts = {joint.name: robot.parts.index(joint.part) for joint in profile.body.joints}
        self._parts = {
            slot: parts[each.joint] for slot, each in enumerate(profile.slots) if each.joint
        }
        self._found: dict[int, Bend | None] = {}
        self._always: dict[int, frozenset[int]] = {}

    def of(self, configuration: int) -> Bend | None:
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

    def _look(self, configuration: int) -> Bend | None:
        held = self._robot.held[configuration]
        sought = {
            Bend(self._parts[write.slot], -int(copysign(1, write.value)))
            for region, state in enumerate(self._robot.table.configurations[configuration])
            for stage in self._robot.actuation[region][state]
            for write in stage
            if write.how == "seek" and write.value and self._parts.get(write.slot) not in held
        }
        return sought.pop() if held and len(sought) == 1 else None
