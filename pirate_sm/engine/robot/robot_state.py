"""The robot as it has been commanded, and what follows from that; nothing here changes it."""

from __future__ import annotations

from functools import lru_cache
from math import inf, isnan, nan
from typing import Literal, NamedTuple

from pirate_sm.engine.control.loops import Loops
from pirate_sm.engine.control.position_loop import PositionLoop
from pirate_sm.engine.records import often_replaced
from pirate_sm.engine.robot.chart_table import Configuration
from pirate_sm.engine.robot.command_spec import PostureSpec, StageSpec
from pirate_sm.engine.robot.criteria import CriterionSpec
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model.effects import StateChange

Numbers = tuple[float, ...]
Purpose = Literal["gate", "loop", "stream", "stop"]

POSTURE = -1
"""The stage of a motion in which the robot takes the command's posture, before all others."""


STOPPED = -1
"""In place of a mark's command: the wheels of the region were stopped from outside its state."""

DECLARED = -2
"""In place of a mark's command: a person or a file has said so."""


DENIED = -3
"""In place of a mark's command: sensors have shown that it is not so, or may be so no more."""


class Mark(NamedTuple):
    """A region's state, or a part's clamp, that is not confirmed.

    Attributes:
        command: The command that made it, or ``STOPPED``, ``DECLARED`` or ``DENIED``.
    """

    kind: Literal["region", "part"]
    which: int
    command: int


Marks = frozenset[Mark]

MOST_REMEMBERED = 4096
"""Answers of one kind; a robot has some hundred situations and twenty commands."""


class Flight(NamedTuple):
    """An array whose fate is not known yet.

    Attributes:
        purpose: ``gate``: a command's first array, moves the chart when accepted. ``stop``: wheels
            zero. ``stream``: the duties of loops that states own. ``loop``: anything else of a
            command, such as the duties of its position loops.
        resend_at_s: When the same array is sent again, infinite while a result is awaited.
        seeking: Slots whose values a loop has set that leaves zero behind when it stops.
        since_s: Since when no array of the stream has been confirmed; NaN for another array.
        before: The loops that go on if a command's first array is refused.
    """

    setpoint_id: int
    values: Numbers
    purpose: Purpose
    tries: int = 1
    resend_at_s: float = inf
    seeking: frozenset[int] = frozenset()
    since_s: float = nan
    before: Loops = ()


@often_replaced
class Motion(NamedTuple):
    """A command under way.

    Attributes:
        command: Index of the command.
        target: The configuration that acceptance leads to.
        accepted_s: NaN until the array is accepted.
        deadline_s: When it has failed; infinite until accepted.
        since_s: Since when its criterion has been true, NaN while it is not.
        stage: Which stage of its actuation is in force; ``POSTURE`` before the first.
        blind: Why its posture cannot be taken: an angle that it needs is unknown. Empty otherwise.
    """

    command: int
    target: int
    timeout_s: float
    place: str
    accepted_s: float = nan
    deadline_s: float = inf
    since_s: float = nan
    stage: int = 0
    blind: str = ""


class Finished(NamedTuple):
    """How a command ended."""

    done: bool
    reason: str


@often_replaced
class RobotState(NamedTuple):
    """The robot as far as it has been commanded.

    Attributes:
        configuration: Index into the chart's table.
        marks: What is not confirmed.
        values: Setpoints in force: the last accepted array.
        loops: The loops that run: those of the command under way, and those of states.
        seeking: Slots among the values that a loop has set that leaves zero behind when it stops: a
            position loop, or any loop of a self-locking motor.
        next_id: Id of the next new array.
        sent: Whether anything has ever been sent.
        overtaken: Arrays of loops whose fate was not known when a newer one was sent.
        control: Index of the control that actuates the states.
    """

    configuration: int
    values: Numbers
    marks: Marks = frozenset()
    next_id: int = 1
    flight: Flight | None = None
    motion: Motion | None = None
    loops: Loops = ()
    seeking: frozenset[int] = frozenset()
    sent: bool = False
    overtaken: tuple[Flight, ...] = ()
    control: int = 0

    def stages(self, robot: RobotSpec, region: int, state: str) -> tuple[StageSpec, ...]:
        """Return the stages of a region's state under the control in force."""
        return robot.controls[self.control].actuation[region][state]

    @property
    def awaited(self) -> Flight | None:
        """Return the array in flight that the next one waits for; none waits for a stream."""
        flight = self.flight
        return None if flight is None or flight.purpose == "stream" else flight

    @property
    def seekers(self) -> tuple[PositionLoop, ...]:
        """Return the position loops that run."""
        if not self.loops:  # asked at every frame, and mostly there are none
            return ()
        return tuple([each for each in self.loops if isinstance(each, PositionLoop)])

    def at_rest(self) -> RobotState:
        """Return the robot between two missions: nothing is under way, no loop runs.

        The next one is actuated by the usual control, unless it names another.
        """
        return self._replace(flight=None, motion=None, loops=(), overtaken=(), control=0)

    @property
    def latest(self) -> Numbers:
        """Return the newest values, whether accepted yet or not."""
        return self.flight.values if self.flight else self.values


def at_rest_in(robot: RobotSpec, configuration: int) -> RobotState:
    """Return a robot in this configuration, confirmed, that has not been sent anything."""
    values = [0.0] * len(robot.slots)
    for region, state in enumerate(robot.table.configurations[configuration]):
        for write in robot.actuation[region][state][-1]:
            if write.how == "set":
                values[write.slot] = write.value
            elif write.how == "keep" and robot.slots[write.slot].unit == "angle":
                values[write.slot] = nan  # known once measured
    return RobotState(configuration, tuple(values))


def unconfirmed(robot: RobotSpec, state: RobotState) -> tuple[str, ...]:
    """Return the regions whose state is not confirmed, in the order of the chart."""
    return state_change(robot, state).unconfirmed


def states_of(robot: RobotSpec, state: RobotState) -> Configuration:
    """Return the state name of each region."""
    return robot.table.configurations[state.configuration]


def obeyed(robot: RobotSpec, state: RobotState) -> tuple[str | None, ...]:
    """Return the state of each region; None where its wheels have been stopped from outside it."""
    names = states_of(robot, state)
    driven = robot.driven[state.configuration]
    if not driven:
        return names
    stopped = {
        region for region, slots in driven.items() if all(state.values[slot] == 0 for slot in slots)
    }
    return tuple(None if region in stopped else name for region, name in enumerate(names))


def state_change(robot: RobotSpec, state: RobotState) -> StateChange:
    """Return the effect that tells the configuration and what of it is unconfirmed."""
    return _state_change(robot, state.configuration, state.marks)


def confirmed_parts(robot: RobotSpec, state: RobotState) -> frozenset[int]:
    """Return the parts whose clamp has been seen to hold."""
    return confirmed_at(robot, state.configuration, state.marks)


# What follows from a configuration and its marks is asked again and again: it is remembered.


@lru_cache(maxsize=MOST_REMEMBERED)
def _state_change(robot: RobotSpec, here: int, marks: Marks) -> StateChange:
    regions = {mark.which for mark in marks if mark.kind == "region"}
    for mark in marks:
        if mark.kind == "part":
            regions |= robot.part_regions[mark.which]
    doubted = tuple(name for index, name in enumerate(robot.regions) if index in regions)
    return StateChange(robot.table.configurations[here], doubted)


def confirmed_at(robot: RobotSpec, here: int, marks: Marks) -> frozenset[int]:
    """Return the parts that hold in a configuration of which these marks are not confirmed."""
    held = robot.held[here]
    if not marks:
        return held
    return held - {mark.which for mark in marks if mark.kind == "part"}


def safe_values(robot: RobotSpec, state: RobotState, numbers: Numbers) -> Numbers:
    """Return the safe array: the last accepted actuation, wheels at zero, loops stopped.

    Args:
        robot: The robot.
        state: What has been accepted. A command that has not been is no part of it: its loops
            may be those of a clamp that is still held.
        numbers: Signals; an angle to be kept is the measured one.
    """
    values = list(known_values(state.values, numbers, robot))
    for slot in (*robot.safe_zero, *state.seeking):
        values[slot] = 0.0
    return tuple(values)


def is_safe(robot: RobotSpec, state: RobotState) -> bool:
    """Whether the setpoints in force are those of the safe state already."""
    if state.loops or state.seeking:
        return False
    return all(state.values[slot] == 0 for slot in robot.safe_zero)


def next_deadline(robot: RobotSpec, state: RobotState, nominal: bool) -> float:
    """Return when time alone changes something: a timeout, a resend, a criterion held long."""
    if state.awaited is not None:
        return state.awaited.resend_at_s  # a command does not end before that is resolved
    motion, resend_at_s = state.motion, state.flight.resend_at_s if state.flight else inf
    if motion is None:
        return resend_at_s
    if nominal:
        return motion.accepted_s + robot.commands[motion.command].nominal_s
    if isnan(motion.since_s):
        return min(motion.deadline_s, resend_at_s)
    held_s = getattr(criterion_of(robot, motion), "for_s", 0.0)
    return min(motion.since_s + held_s, motion.deadline_s, resend_at_s)


def posture_of(robot: RobotSpec, motion: Motion) -> PostureSpec | None:
    """Return the posture that the command under way takes first, or took; None without one."""
    return robot.commands[motion.command].posture(motion.target)


def criterion_of(robot: RobotSpec, motion: Motion) -> CriterionSpec:
    """Return what shows that the stage of the command under way is done."""
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    return robot.commands[motion.command].done if posture is None else posture.done


def known_values(values: Numbers, numbers: Numbers, robot: RobotSpec) -> Numbers:
    """Return values of which none is unknown: a kept angle is the measured one, or 0 [decided]."""
    if not isnan(sum(values)):  # one unknown makes the sum unknown
        return values
    filled = list(values)
    for index, value in enumerate(values):
        if isnan(value):
            angle = robot.slots[index].angle
            seen = numbers[angle] if angle >= 0 else nan
            filled[index] = 0.0 if isnan(seen) else seen
    return tuple(filled)
