"""Follow the course of a mission without failures: its commands and configurations.

Every command succeeds, and every trigger and answer is possible. Failures, faults and waits that
time out are ignored. The geometry is checked against this intended course;
:mod:`pirate_sm.checking.exploring` covers everything else.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import copysign
from typing import NamedTuple

from pirate_sm.checking.actuation_in_force import Actuated
from pirate_sm.engine.mission import program as steps
from pirate_sm.engine.mission.program import Program
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model.profile import Profile

MOST_SITUATIONS = 100_000
"""Largest number of situations; a larger mission is not checked in its pipe."""


class Bend(NamedTuple):
    """A part that is bent while another one holds.

    Attributes:
        part: Index of the part.
        side: 1 towards side A in normal polarity, -1 away from it.
    """

    part: int
    side: int


class CoursePoint(NamedTuple):
    """A point in the course of a mission.

    Attributes:
        at: Index of the next instruction.
        configuration: Index into the chart's table.
        bent: Parts that have been bent so far, in order.
        control: Index of the control in force.
        driven: Whether wheels have been driven so far.
        place: Place of the step that led to the configuration or to the control; empty at the
            start.
    """

    at: int
    configuration: int
    bent: tuple[int, ...]
    control: int = 0
    driven: bool = False
    place: str = ""

    @property
    def actuated(self) -> Actuated:
        """Return the configuration with the control in force."""
        return Actuated(self.configuration, self.control)


@dataclass(frozen=True)
class UsualCourse:
    """The course of a mission without failures.

    Attributes:
        situations: All points of the course, in breadth-first order.
        bends: Bends with the places of their steps; "" for a bend at the start.
    """

    situations: tuple[CoursePoint, ...]
    bends: tuple[tuple[Bend, str], ...]


class Bends:
    """Finds the configurations of a robot, in one polarity, that bend a part.

    In a bend, joints of a part that is not held have target angles to one side, while another part
    is held. A negative angle turns the body on both sides of the joint to side A. What a state is,
    its usual actuation says: no control seeks an angle.
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


@dataclass(frozen=True)
class _Follower:
    """Follows a mission from one point to the next.

    Attributes:
        made: The distinct bends with the places of their steps.
    """

    robot: RobotSpec
    program: Program
    bends: Bends
    made: dict[tuple[Bend, str], None] = field(default_factory=dict)

    def after(self, now: CoursePoint) -> Iterator[CoursePoint]:
        """Yield the possible next points."""
        if not 0 <= now.at < len(self.program.instructions):
            return
        step = self.program.instructions[now.at]
        if isinstance(step, steps.Do):
            yield from self._command(step, now)
        elif isinstance(step, steps.SwitchControl):
            yield now._replace(at=step.next, control=step.control, place=step.place)
        else:
            for target in self._targets(step, now.configuration):
                yield now._replace(at=target)

    def _command(self, step: steps.Do, now: CoursePoint) -> Iterator[CoursePoint]:
        after = self.robot.table.follow(now.configuration, step.command)
        if after == now.configuration:
            if step.skip_unneeded and self.robot.unneeded[after][step.command]:
                yield now._replace(at=step.next)
            return
        bend = self.bends.of(after)
        if bend is not None and bend != self.bends.of(now.configuration):
            self.made.setdefault((bend, step.place))
        yield now._replace(
            at=step.next,
            configuration=after,
            bent=self.bent(after, now.bent),
            driven=now.driven or bool(self.robot.driven[after]),
            place=step.place,
        )

    def bent(self, configuration: int, before: tuple[int, ...]) -> tuple[int, ...]:
        """Return the bent parts, including that of the configuration."""
        bend = self.bends.of(configuration)
        return before if bend is None or bend.part in before else (*before, bend.part)

    def _targets(self, step: steps.Instruction, configuration: int) -> tuple[int, ...]:
        match step:
            case steps.Enter() | steps.Say():
                return (step.next,)
            case steps.Require(states=states):
                current = self.robot.table.configurations[configuration]
                fits = all(current[region] == state for region, state in states)
                return (step.next,) if fits else ()
            case steps.Branch():
                return self._branch(step, configuration)
            case steps.Wait(triggers=triggers):
                return tuple(trigger.go for trigger in triggers)
            case steps.Question(choices=choices):
                return tuple(target for _, target in choices)
            case steps.Do() | steps.SwitchControl() | steps.Raise() | steps.Finish():
                return ()

    def _branch(self, step: steps.Branch, configuration: int) -> tuple[int, ...]:
        """Return both targets, unless the states alone decide."""
        known = step.condition.names <= set(self.robot.regions)
        if not known:
            return (step.if_true, step.if_false)
        states = self.robot.table.configurations[configuration]
        numbers = (0.0,) * len(self.robot.vocabulary.numbers)
        true = step.condition.evaluate(numbers, states) is True
        return (step.if_true,) if true else (step.if_false,)


def course_of(robot: RobotSpec, program: Program, profile: Profile) -> UsualCourse | None:
    """Return the course of the mission without failures; None if it is too large."""
    bends = Bends(robot, profile)
    follower = _Follower(robot, program, bends)
    configuration = program.start_configuration
    driven = bool(robot.driven[configuration])
    bent = follower.bent(configuration, ())
    first = CoursePoint(program.start, configuration, bent, driven=driven)
    found = {first[:-1]: first}
    order = [first]
    for now in order:
        for after in follower.after(now):
            if after[:-1] not in found:
                found[after[:-1]] = after
                order.append(after)
                if len(order) > MOST_SITUATIONS:
                    return None
    begun = bends.of(configuration)
    made = [(begun, "")] if begun is not None else []
    return UsualCourse(tuple(order), (*made, *follower.made))
