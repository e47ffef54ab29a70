"""Follow the course of a mission: its commands and configurations.

Every trigger and answer is possible. Unless they are asked for, every command succeeds, and
failures, faults and waits that time out are ignored. The geometry is checked against this intended
course; what a wait can never see, against all ways to it;
:mod:`pirate_sm.checking.exploring` covers everything else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import copysign
from typing import NamedTuple

from pirate_sm.checking.actuation_in_force import Actuated, InForce
from pirate_sm.checking.pipe.robot_in_pipe import PartRolls, RollJoint
from pirate_sm.core import program as steps
from pirate_sm.core.robot import RobotSpec

# --- bends ---------------------------------------------------------------------------------------


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


# --- course points -------------------------------------------------------------------------------


class CoursePoint(NamedTuple):
    """A point in the course of a mission.

    Attributes:
        at: Index of the next instruction.
        configuration: Index into the chart's table.
        bent: Parts that have been bent into the current bend so far, in order.
        control: Index of the active control.
        driven: Whether wheels have been driven so far.
        way: Direction in which they were driven last, 1 forward, -1 backward; 0 if unknown.
        passed: How many bends the robot has passed forward, less those backward; without the
            present one.
        rolls: How the parts are rolled; None if unknown.
        wound: Parts that are relaxed with their worms wound.
        place: Place of the step that led to the configuration or to the control; empty at the
            start.
    """

    at: int
    configuration: int
    bent: tuple[int, ...]
    control: int = 0
    driven: bool = False
    way: int = 0
    passed: int = 0
    rolls: PartRolls | None = PartRolls()
    wound: frozenset[int] = frozenset()
    place: str = ""

    @property
    def actuated(self) -> Actuated:
        """Return the configuration with the active control."""
        return Actuated(self.configuration, self.control)


class Change(NamedTuple):
    """A command that changes the configuration.

    Attributes:
        command: Index of the command.
        before: The point before it.
        after: The point after it, whose place is that of the step.
    """

    command: int
    before: CoursePoint
    after: CoursePoint


class Bending(NamedTuple):
    """A part that is bent into a bend of the pipe.

    Attributes:
        bend: Which part, and to which side.
        point: The point at which it is bent; its place is empty for a bend at the start.
        joint: Into which bend, counted from the robot's start: 0 is the first ahead of it, -1 the
            first after it.
        roll: Roll of the part in quarter turns; None if unknown.
    """

    bend: BentPart
    point: CoursePoint
    joint: int
    roll: float | None


@dataclass(frozen=True)
class UsualCourse:
    """The course of a mission without failures.

    Attributes:
        situations: All points of the course, in breadth-first order.
        bends: The distinct bends.
        turns: The commands that turn the roll joint, each from a point of its own.
        came: The point from which each point was reached first.
        leads: Of each part the direction in which it leads: 1 forward, -1 backward, 0 in neither.
        onward: The points that may follow each point, by its fields without the place.
    """

    situations: tuple[CoursePoint, ...]
    bends: tuple[Bending, ...]
    turns: tuple[Change, ...]
    came: Mapping[CoursePoint, CoursePoint]
    leads: tuple[int, ...]
    onward: Mapping[tuple[object, ...], tuple[CoursePoint, ...]]

    def way_to(self, point: CoursePoint) -> tuple[CoursePoint, ...]:
        """Return the points with a step of their own that lead to a point, in order."""
        found = [point]
        while found[-1] in self.came:
            found.append(self.came[found[-1]])
        steps = [
            after
            for before, after in zip(found[1:], found, strict=False)
            if after.place != before.place
        ]
        return tuple(reversed(steps))


# --- the course ----------------------------------------------------------------------------------


MOST_SITUATIONS = 100_000
"""Largest number of situations; a larger mission is not checked in its pipe."""


@dataclass(frozen=True)
class _Follower:
    """Follows a mission from one point to the next.

    Attributes:
        joints: How many bends the pipe has; more are not counted.
        ways: Directions of configurations that were looked up.
        failing: Whether failures, time limits and fault handlers are followed too.
        made: The distinct bends.
        turned: The changes that turn the roll joint.
    """

    force: InForce
    program: steps.Program
    bends: Bends
    roll_joint: RollJoint
    leads: tuple[int, ...]
    joints: int
    failing: bool = False
    ways: dict[int, int] = field(default_factory=dict)
    made: dict[tuple[BentPart, int, int, float | None], Bending] = field(default_factory=dict)
    turned: list[Change] = field(default_factory=list)

    @property
    def robot(self) -> RobotSpec:
        """Return the engine's specification of the robot."""
        return self.force.robot

    def after(self, now: CoursePoint) -> Iterator[CoursePoint]:
        """Yield the possible next points."""
        if not 0 <= now.at < len(self.program.instructions):
            return
        done = tuple(self._done(now))
        yield from done
        if self.failing:
            # A command that failed may have been refused, or begun: states are as if it was done.
            for target in self.program.failures(now.at):
                yield from (each._replace(at=target) for each in (now, *done))

    def _done(self, now: CoursePoint) -> Iterator[CoursePoint]:
        """Yield the possible next points without a failure."""
        step, states = (
            self.program.instructions[now.at],
            self.robot.table.configurations[now.configuration],
        )
        match step:
            case steps.Do():
                yield from self._command(step, now)
            case steps.SwitchControl():
                yield now._replace(at=step.next, control=step.control, place=step.place)
            case steps.Require() if any(states[region] != state for region, state in step.states):
                pass
            case steps.Branch() if step.condition.names <= set(self.robot.regions):
                numbers = (0.0,) * len(self.robot.vocabulary.numbers)
                true = step.condition.evaluate(numbers, states) is True
                yield now._replace(at=step.if_true if true else step.if_false)
            case _:
                yield from (now._replace(at=to) for to in self.program.successes(now.at))

    def _command(self, step: steps.Do, now: CoursePoint) -> Iterator[CoursePoint]:
        after = self.robot.table.follow(now.configuration, step.command)
        if after == now.configuration:
            # What a fault has stopped is not unneeded.
            if (step.skip_unneeded or self.failing) and self.robot.unneeded[after][step.command]:
                yield now._replace(at=step.next)
            return
        bent, passed = self.bent(now, after)
        was, joint = now.configuration, self.roll_joint
        found = now._replace(
            at=step.next,
            configuration=after,
            bent=bent,
            driven=now.driven or bool(self.robot.driven[after]),
            way=self.way(after) or now.way,
            passed=passed,
            rolls=joint.after(now.rolls, was, after),
            wound=joint.wound(now.wound, was, step.command, after),
            place=step.place,
        )
        self.note(found, was)
        if joint.turns(was, after):
            self.turned.append(Change(step.command, now, found))
        yield found

    def note(self, point: CoursePoint, before: int | None = None) -> None:
        """Note a bend that a point makes, unless the configuration before it made the same."""
        bend = self.bends.of(point.configuration)
        if bend is None or (before is not None and bend == self.bends.of(before)):
            return
        back = self.leads[point.bent[0]] < 0
        roll = None if point.rolls is None else self.roll_joint.roll(point.rolls, bend.part)
        found = Bending(bend, point, point.passed - back, roll)
        self.made.setdefault((bend, point.at, found.joint, roll), found)

    def bent(self, now: CoursePoint, after: int) -> tuple[tuple[int, ...], int]:
        """Return the parts that are bent in the current bend, and how many bends are passed.

        Once all parts have been bent, a part that leads in the direction of the last drive bends
        into the next bend.
        """
        bend = self.bends.of(after)
        if bend is None or bend.part not in now.bent:
            return now.bent if bend is None else (*now.bent, bend.part), now.passed
        complete = len(now.bent) == len(self.robot.parts)
        if bend == self.bends.of(now.configuration) or not complete:
            return now.bent, now.passed
        if self.leads[bend.part] != now.way or not now.way:
            return now.bent, now.passed
        passed = now.passed + self.leads[now.bent[0]]
        return (bend.part,), min(max(passed, -self.joints), self.joints)

    def way(self, configuration: int) -> int:
        """Return the direction in which a configuration drives the robot; 0 if it does not."""
        if configuration in self.ways:
            return self.ways[configuration]
        values = [0.0] * len(self.robot.slots)
        for write in self.force.last_writes(Actuated(configuration)):
            if write.turns:
                values[write.slot] = write.value
        return self.ways.setdefault(configuration, self.robot.travel(values))


def course_of(
    force: InForce, program: steps.Program, joints: int = 0, *, failing: bool = False
) -> UsualCourse | None:
    """Return the course of the mission; None if it is too large.

    Args:
        force: What the robot's states write, in the polarity of the mission.
        program: The mission.
        joints: How many bends its pipe has.
        failing: Whether failures, time limits and fault handlers are followed too.
    """
    wheels = force.profile.body.wheels
    leads = tuple(
        1 if part == wheels[0].part else -1 if part == wheels[-1].part else 0
        for part in force.robot.parts
    )
    follower = _Follower(force, program, Bends(force), RollJoint(force), leads, joints, failing)
    order, came = [_first(follower)], dict[CoursePoint, CoursePoint]()
    follower.note(order[0])
    found, onward = {order[0][:-1]}, dict[tuple[object, ...], tuple[CoursePoint, ...]]()
    for now in order:
        onward[now[:-1]] = tuple(follower.after(now))
        for after in onward[now[:-1]]:
            if after != order[0]:
                came.setdefault(after, now)
            if after[:-1] not in found:
                found.add(after[:-1])
                order.append(after)
                if len(order) > MOST_SITUATIONS:
                    return None
    made = tuple(follower.made.values())
    return UsualCourse(tuple(order), made, tuple(follower.turned), came, leads, onward)


def _first(follower: _Follower) -> CoursePoint:
    """Return the point at which the mission begins."""
    robot, program = follower.robot, follower.program
    configuration = program.start_configuration
    point = CoursePoint(
        program.start,
        configuration,
        (),
        driven=bool(robot.driven[configuration]),
        way=follower.way(configuration),
        rolls=None if follower.roll_joint.aim(configuration) else PartRolls(),
    )
    return point._replace(bent=follower.bent(point, configuration)[0])
