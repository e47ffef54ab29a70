"""Effects: the closed set of what the engine asks for or reports.

Only the runtime performs them. ``Setpoints`` moves the robot; the others inform.
"""

from __future__ import annotations

from math import degrees, isnan
from typing import Literal, NamedTuple, TypeAlias

CommandState: TypeAlias = Literal["sent", "accepted", "refused", "done", "failed", "skipped"]
Outcome: TypeAlias = Literal["succeeded", "failed", "interrupted", "fault"]


class Setpoints(NamedTuple):
    """All slots shall take these values at once.

    Attributes:
        setpoint_id: Rises by one with each new array; the same id means the same array again.
        values: One value per slot in wire order: duty cycle -1..1 or angle in rad, as the
            profile says for the slot.
    """

    setpoint_id: int
    values: tuple[float, ...]


class CommandStatus(NamedTuple):
    """A command has come to a new point of its life.

    Attributes:
        name: The command.
        status: Where it is now.
        reason: Why it was refused or failed, how it was done; may be empty.
        place: Where it stands in the mission file, ``file:line:col``; empty for the operator's.
    """

    name: str
    status: CommandState
    reason: str = ""
    place: str = ""


class StateChange(NamedTuple):
    """The robot's configuration, or how much of it is confirmed, has changed.

    Attributes:
        states: State name per region, in the order of the chart.
        unconfirmed: Regions whose state has been commanded but not yet seen to be true.
    """

    states: tuple[str, ...]
    unconfirmed: tuple[str, ...]


class PhaseChange(NamedTuple):
    """The mission has entered a phase."""

    phase: str


class WaitArmed(NamedTuple):
    """A phase, or a step of it, waits.

    Attributes:
        phase: Name of the phase.
        triggers: Names of the triggers in listed order.
        conditions: What each of them waits for, in the words of the file.
        deadline_s: Mission time at which ``within`` ends the wait; infinite if it never does.
        place: Where the wait stands, ``file:line:col``.
    """

    phase: str
    triggers: tuple[str, ...]
    conditions: tuple[str, ...]
    deadline_s: float
    place: str = ""


TAKEN = "taken by the operator"
"""Reason of a trigger that nothing but a person, or a script in their place, has made fire."""


class TriggerFired(NamedTuple):
    """A wait has ended.

    Attributes:
        phase: The phase that waited.
        trigger: Name of the trigger, ``within`` for the time limit.
        go: The phase or end that comes next.
        reason: What made it fire.
        place: Where the wait stands, ``file:line:col``.
    """

    phase: str
    trigger: str
    go: str
    reason: str
    place: str = ""


class Detected(NamedTuple):
    """A detector's word has become the valid one."""

    word: str


class Environment(NamedTuple):
    """The pipe around the robot has changed, by more than noise.

    Attributes:
        segment: ``Out``, ``Straight`` or ``Joint`` (thesis section 4-3-2); empty is unknown.
        roll_rad: Roll of the robot about the axis of the pipe, against the horizontal; NaN is
            unknown, as for the others.
        pitch_rad: Pitch of the pipe's axis, positive where it climbs ahead of the robot.
        diameter_m: Inner diameter, h + 2r (thesis eq. 3-2).
    """

    segment: str
    roll_rad: float
    pitch_rad: float
    diameter_m: float

    @property
    def measures(self) -> str:
        """Return the known ones of roll, pitch and diameter as text; empty where none is."""
        known = [
            f"{name} {degrees(angle):.0f}°"
            for name, angle in (("roll", self.roll_rad), ("pitch", self.pitch_rad))
            if not isnan(angle)
        ]
        if not isnan(self.diameter_m):
            known.append(f"inner diameter {self.diameter_m * 1e3:.1f} mm")
        return ", ".join(known)


class Fault(NamedTuple):
    """Something is wrong that nobody commanded.

    Attributes:
        code: Name of the fault, as missions write it.
        message: One sentence for the operator.
        handling: ``continue``, the phase it leads to, or ``stop``.
    """

    code: str
    message: str
    handling: str


class Log(NamedTuple):
    """A line for the operator."""

    level: Literal["info", "warning", "error"]
    message: str


class Ask(NamedTuple):
    """The mission needs an answer from the operator.

    Attributes:
        question: What is asked; empty when a pending question is withdrawn.
        choices: The answers on offer, the first being the expected one.
    """

    question: str
    choices: tuple[str, ...]


class WakeAt(NamedTuple):
    """Nothing can change before ``at_s`` unless an event comes first; infinity: never."""

    at_s: float


class Ended(NamedTuple):
    """The run is over and the safe stop has been asked for.

    Attributes:
        outcome: How it ended.
        message: Why, in one sentence.
        end: Name of the mission's end, empty when it ended otherwise.
    """

    outcome: Outcome
    message: str
    end: str = ""


Effect: TypeAlias = (
    Setpoints
    | CommandStatus
    | StateChange
    | PhaseChange
    | WaitArmed
    | TriggerFired
    | Detected
    | Environment
    | Fault
    | Log
    | Ask
    | WakeAt
    | Ended
)
