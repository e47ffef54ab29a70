"""The commanded state of the robot, and what can be derived from it."""

from __future__ import annotations

from functools import lru_cache
from math import inf, isnan, nan
from typing import Literal, NamedTuple

from pirate_sm.core._engine.records import Numbers, often_replaced
from pirate_sm.core._engine.robot.actuation_spec import StageSpec
from pirate_sm.core._engine.robot.criteria import Bound, CriterionSpec, near
from pirate_sm.core._engine.robot.loops import Loops, RunningPositionLoop
from pirate_sm.core._engine.robot.robot_spec import Configuration, PostureSpec, RobotSpec
from pirate_sm.core._geometry.space import Vector
from pirate_sm.core.effects import StateChange

Purpose = Literal["gate", "loop", "stream", "stop"]

POSTURE = -1
"""The stage in which the robot reaches the command's posture, before all other stages."""

RESTORING = "resume"
"""The place of a command that a resumed mission gives before it goes on."""

STOPPED = -1
"""In place of a mark's command: a pause or a fault has stopped the wheels of the region."""

DECLARED = -2
"""In place of a mark's command: a person or a file has declared the state."""


DENIED = -3
"""In place of a mark's command: sensors contradict the state, or it may have been lost."""


LAPSED = -4
"""In place of a mark's command: the sensors that showed that the part holds are not known now."""


class Mark(NamedTuple):
    """A region's state or a part's clamp that is not confirmed.

    Attributes:
        command: The command that set it, or ``STOPPED``, ``DECLARED``, ``DENIED`` or ``LAPSED``.
    """

    kind: Literal["region", "part"]
    which: int
    command: int


Marks = frozenset[Mark]

MOST_REMEMBERED = 4096
"""Size of each cache; a robot has some hundred configurations and twenty commands."""


class Levelling(NamedTuple):
    """The memory of a command that brings the part that turns to an angle against the horizontal.

    Attributes:
        slot: The slot that turns it.
        target_rad: The angle against the horizontal; a half turn more is the same plane.
        felt: The specific forces measured since the robot is at rest, in the axes of the pipe with
            the holding part in its plane: along the pipe, towards side B and up, m/s^2.
        since_s: When the first of them was measured.
        heard_s: When the accelerometer last reported.
        roll_rad: The angle of the roll joint at the first of them.
        turns: How often a setpoint has been computed.
    """

    slot: int
    target_rad: float
    felt: tuple[Vector, ...] = ()
    since_s: float = nan
    heard_s: float = -inf
    roll_rad: float = nan
    turns: int = 0


class Flight(NamedTuple):
    """An array without a result so far.

    Attributes:
        purpose: ``gate``: a command's first array, which moves the chart when accepted. ``stop``:
            the safe array. ``stream``: the duties of the loops of states. ``loop``: any other
            array of a command, such as the duties of its position loops.
        resend_at_s: When the same array is sent again; infinite while a result is awaited.
        seeking: Slots driven by a loop that leaves zero behind when it stops.
        since_s: Since when no array of the stream has been confirmed; NaN for other arrays.
        before: The loops that continue if a command's first array is refused.
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
        target: The configuration after acceptance.
        accepted_s: NaN until the array is accepted.
        deadline_s: When the command fails; infinite until it is accepted.
        since_s: When its criterion became true; NaN while it is not.
        settled_s: The same for what counts as well once it has held for longer.
        stage: The stage of its actuation in force; ``POSTURE`` before the first.
        blind: Why it cannot be done at all, such as a posture that needs an unknown angle; else
            empty.
        levelling: What a command that levels a part has measured; None for others.
        origin: Signals when its present stage began, in the first of several tries; empty where
            they were not kept.
        share: By what the setpoints of wheels are multiplied, without what bears the weight.
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
    levelling: Levelling | None = None
    origin: Numbers = ()
    settled_s: float = nan
    share: float = 1.0


class Finished(NamedTuple):
    """The result of a command."""

    done: bool
    reason: str


@often_replaced
class RobotState(NamedTuple):
    """The commanded state of the robot.

    Attributes:
        configuration: Index into the chart's table.
        marks: The states and clamps that are not confirmed.
        values: Setpoints in force: the last accepted array.
        loops: The running loops: those of the command under way, and those of states.
        seeking: Slots of ``values`` driven by a loop that leaves zero behind when it stops: a
            position loop, or any loop of a self-locking motor.
        next_id: Id of the next new array.
        sent: Whether anything has ever been sent.
        overtaken: Arrays of loops whose fate was not known when a newer one was sent.
        control: Index of the control that actuates the states.
        tried: The command that failed last, until it is done or another one begins.
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
    tried: Motion | None = None

    def stages(self, robot: RobotSpec, region: int, state: str) -> tuple[StageSpec, ...]:
        """Return the stages of a region's state under the control in force."""
        return robot.controls[self.control].actuation[region][state]

    @property
    def awaited(self) -> Flight | None:
        """Return the array in flight that the next one must wait for; None for a stream."""
        flight = self.flight
        return None if flight is None or flight.purpose == "stream" else flight

    @property
    def seekers(self) -> tuple[RunningPositionLoop, ...]:
        """Return the running position loops."""
        if not self.loops:  # runs at every frame; usually there are none
            return ()
        return tuple([each for each in self.loops if isinstance(each, RunningPositionLoop)])

    def at_rest(self) -> RobotState:
        """Return the robot between two missions: nothing is under way, no loop runs.

        The next one is actuated by the usual control, unless it names another.
        """
        rest = self._replace(flight=None, motion=None, loops=(), overtaken=(), control=0)
        return rest._replace(tried=None)

    @property
    def latest(self) -> Numbers:
        """Return the values of the newest array, accepted or not."""
        return self.flight.values if self.flight else self.values


def at_rest_in(robot: RobotSpec, configuration: int) -> RobotState:
    """Return a robot confirmed in this configuration, before any array was sent."""
    values = [0.0] * len(robot.slots)
    for region, state in enumerate(robot.table.configurations[configuration]):
        for write in robot.actuation[region][state][-1]:
            if write.how == "set":
                values[write.slot] = write.value
            elif write.how in ("keep", "level") and robot.slots[write.slot].unit == "angle":
                values[write.slot] = nan  # known once measured
    return RobotState(configuration, tuple(values))


def unconfirmed(robot: RobotSpec, state: RobotState) -> tuple[str, ...]:
    """Return the regions whose state is not confirmed, in the order of the chart."""
    return state_change(robot, state).unconfirmed


def states_of(robot: RobotSpec, state: RobotState) -> Configuration:
    """Return the state name of each region."""
    return robot.table.configurations[state.configuration]


def obeyed(robot: RobotSpec, state: RobotState) -> tuple[str | None, ...]:
    """Return the state of each region; None where a pause or a fault has stopped its wheels."""
    names = states_of(robot, state)
    driven = robot.driven[state.configuration]
    if not driven:
        return names
    stopped = {
        region for region, slots in driven.items() if all(state.values[slot] == 0 for slot in slots)
    }
    return tuple(None if region in stopped else name for region, name in enumerate(names))


def state_change(robot: RobotSpec, state: RobotState) -> StateChange:
    """Return the effect that reports the configuration and its unconfirmed regions."""
    return _state_change(robot, state.configuration, state.marks)


def confirmed_parts(robot: RobotSpec, state: RobotState) -> frozenset[int]:
    """Return the held parts whose clamp is confirmed."""
    return confirmed_at(robot, state.configuration, state.marks)


# These functions of a configuration and its marks are called often, so their results are cached.


@lru_cache(maxsize=MOST_REMEMBERED)
def _state_change(robot: RobotSpec, here: int, marks: Marks) -> StateChange:
    regions = {mark.which for mark in marks if mark.kind == "region"}
    for mark in marks:
        if mark.kind == "part":
            regions |= robot.part_regions[mark.which]
    doubted = tuple(name for index, name in enumerate(robot.regions) if index in regions)
    return StateChange(robot.table.configurations[here], doubted)


def confirmed_at(robot: RobotSpec, here: int, marks: Marks) -> frozenset[int]:
    """Return the held parts of a configuration, without those that these marks concern."""
    held = robot.held[here]
    if not marks:
        return held
    return held - {mark.which for mark in marks if mark.kind == "part"}


def safe_values(robot: RobotSpec, state: RobotState, numbers: Numbers) -> Numbers:
    """Return the safe array: the last accepted actuation, wheels at zero, loops stopped.

    Args:
        robot: The robot.
        state: The robot's state. Only the accepted actuation counts: the slots of a command that
            is not accepted may still hold a clamp.
        numbers: Signals; an angle that is kept is the measured one.
    """
    values = list(known_values(state.values, numbers, robot))
    for slot in (*robot.safe_zero, *state.seeking):
        values[slot] = 0.0
    return tuple(values)


def is_safe(robot: RobotSpec, state: RobotState) -> bool:
    """Return whether the setpoints in force are those of the safe state."""
    if state.loops or state.seeking:
        return False
    return all(state.values[slot] == 0 for slot in robot.safe_zero)


def next_deadline(robot: RobotSpec, state: RobotState, nominal: bool) -> float:
    """Return the next deadline: a timeout, a resend, or a criterion held long enough."""
    if state.awaited is not None:
        return state.awaited.resend_at_s  # a command cannot end before its array has a result
    motion, resend_at_s = state.motion, state.flight.resend_at_s if state.flight else inf
    if motion is None:
        return resend_at_s
    if nominal:
        return motion.accepted_s + robot.commands[motion.command].nominal_s
    due_s = min(motion.deadline_s, resend_at_s)
    for criterion, since_s in criteria_of(robot, motion):
        if not isnan(since_s):
            due_s = min(due_s, since_s + criterion.for_s)
    return due_s


def posture_of(robot: RobotSpec, motion: Motion) -> PostureSpec | None:
    """Return the posture of the command under way; None without one."""
    return robot.commands[motion.command].posture(motion.target)


def criterion_of(robot: RobotSpec, motion: Motion) -> CriterionSpec:
    """Return the criterion of the present stage of the command under way."""
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    return robot.commands[motion.command].done if posture is None else posture.done


def criteria_of(robot: RobotSpec, motion: Motion) -> tuple[tuple[CriterionSpec, float], ...]:
    """Return each criterion that shows the present stage done, and when it became true, or NaN."""
    done = criterion_of(robot, motion)
    alone = ((done, motion.since_s),)
    return alone if done.settled is None else (*alone, (done.settled, motion.settled_s))


def posture_bounds(robot: RobotSpec, state: RobotState, motion: Motion) -> tuple[Bound, ...]:
    """Return where the joints must be in the posture under way; none outside of one."""
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    if posture is None:
        return ()
    return tuple(  # the tolerance of a posture may be NaN
        near(loop.angle, loop.target_rad, max(loop.spec.threshold_rad, posture.within_rad))
        for loop in state.seekers
    )


def known_values(values: Numbers, numbers: Numbers, robot: RobotSpec) -> Numbers:
    """Return the values with each unknown replaced by the measured angle, or by 0 [decided]."""
    if not isnan(sum(values)):  # one unknown makes the sum unknown
        return values
    filled = list(values)
    for index, value in enumerate(values):
        if isnan(value):
            angle = robot.slots[index].angle
            seen = numbers[angle] if angle >= 0 else nan
            filled[index] = 0.0 if isnan(seen) else seen
    return tuple(filled)
