"""Effects: the closed set of the engine's outputs.

Only the runtime performs them. ``Setpoints`` moves the robot; the others report something.
"""

from __future__ import annotations

from math import degrees, isnan, nan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.model.unmet import Unmet

CommandState: TypeAlias = Literal["sent", "accepted", "refused", "done", "failed", "skipped"]
Outcome: TypeAlias = Literal["succeeded", "failed", "interrupted", "fault"]


class Setpoints(NamedTuple):
    """An array of setpoints to be sent, which takes effect in all slots at once.

    Attributes:
        setpoint_id: Increases by one with each new array; a resent array keeps its id.
        values: One value per slot in wire order: a duty cycle -1..1 or an angle in rad, depending
            on the slot's unit in the profile.
    """

    setpoint_id: int
    values: tuple[float, ...]


class CommandStatus(NamedTuple):
    """The status of a command has changed.

    Attributes:
        name: The command.
        status: The new status.
        reason: Why it was refused or failed, or why it counts as done; may be empty.
        place: Its place in the mission file, ``file:line:col``; empty for an operator's command.
        unmet: What a failed command has awaited, and what the sensors showed instead. The reason
            says the same where these conditions are why it failed.
    """

    name: str
    status: CommandState
    reason: str = ""
    place: str = ""
    unmet: tuple[Unmet, ...] = ()


class StateChange(NamedTuple):
    """The robot's configuration or its unconfirmed regions have changed.

    Attributes:
        states: State name per region, in the order of the chart.
        unconfirmed: Regions whose state is commanded but not confirmed.
    """

    states: tuple[str, ...]
    unconfirmed: tuple[str, ...]


class PhaseChange(NamedTuple):
    """The mission has entered a phase."""

    phase: str


class WaitArmed(NamedTuple):
    """A phase or a step has begun to wait.

    Attributes:
        phase: Name of the phase.
        triggers: Names of the triggers in listed order.
        conditions: The condition of each trigger, as in the file.
        deadline_s: Mission time at which ``within`` ends the wait; infinite without a limit.
        place: Where the wait stands, ``file:line:col``.
    """

    phase: str
    triggers: tuple[str, ...]
    conditions: tuple[str, ...]
    deadline_s: float
    place: str = ""


TAKEN = "taken by the operator"
"""Reason of a trigger fired by the operator, or by a script in place of an operator."""


class TriggerFired(NamedTuple):
    """A wait has ended.

    Attributes:
        phase: The phase that waited.
        trigger: Name of the trigger; ``within`` for the time limit.
        go: The next phase or end.
        reason: Why it fired.
        place: Where the wait stands, ``file:line:col``.
    """

    phase: str
    trigger: str
    go: str
    reason: str
    place: str = ""


class Detected(NamedTuple):
    """The valid word of the detector has changed."""

    word: str


class Environment(NamedTuple):
    """The properties of the pipe around the robot have changed by more than noise.

    Attributes:
        segment: ``Out``, ``Straight`` or ``Joint`` (thesis section 4-3-2); empty is unknown.
        roll_rad: Roll of the robot about the axis of the pipe, against the horizontal; NaN is
            unknown, as for the others.
        pitch_rad: Pitch of the pipe's axis, positive where it climbs ahead of the robot.
        diameter_m: Inner diameter, h + 2r (thesis eq. 3-2).
        joint: The joint that the robot is in, or the next one ahead: ``mitre``, ``elbow``, ``tee``,
            ``reducer`` or ``end``; empty is unknown.
        junction: Name of the tee that the joint is; empty is unknown or none.
        opening_roll_rad: Towards where the pipe turns or opens there: the roll about the direction
            of travel, against the front part's plane; 0 is towards side A of a robot in normal
            polarity.
        distance_m: Distance from the first wheel to the joint; negative behind it.
        diameter_ahead_m: Inner diameter behind the joint.
        run: Name of the run of the pipe that the first wheel is in; empty is unknown.
        arc_m: Place of the first wheel along the route.
    """

    segment: str
    roll_rad: float
    pitch_rad: float
    diameter_m: float
    joint: str = ""
    junction: str = ""
    opening_roll_rad: float = nan
    distance_m: float = nan
    diameter_ahead_m: float = nan
    run: str = ""
    arc_m: float = nan

    @property
    def measures(self) -> str:
        """Return what is known of roll, pitch, diameter and joint as text; empty if nothing is."""
        known = [
            f"{name} {degrees(angle):z.0f}°"
            for name, angle in (("roll", self.roll_rad), ("pitch", self.pitch_rad))
            if not isnan(angle)
        ]
        if not isnan(self.diameter_m):
            known.append(f"inner diameter {self.diameter_m * 1e3:.1f} mm")
        if self.joint:
            known.append(self._joint_words)
        return ", ".join(known)

    @property
    def _joint_words(self) -> str:
        words = " ".join(filter(None, (self.joint, self.junction)))
        if not isnan(self.distance_m):
            where = "ahead" if self.distance_m >= 0 else "back"
            words += f" {abs(self.distance_m) * 1e3:.0f} mm {where}"
        if not isnan(self.diameter_ahead_m):
            words += f", behind it {self.diameter_ahead_m * 1e3:.1f} mm"
        return words


class Fault(NamedTuple):
    """A fault has been found.

    Attributes:
        code: Code of the fault, as missions write it.
        message: One sentence for the operator.
        handling: ``continue``, the target phase, or ``stop``.
        of: The boards, joints, wheels and parts that it is a fault of; empty: nobody's.
    """

    code: str
    message: str
    handling: str
    of: tuple[str, ...] = ()


class Log(NamedTuple):
    """A log line for the operator."""

    level: Literal["info", "warning", "error"]
    message: str


class Ask(NamedTuple):
    """The mission needs an answer from the operator.

    Attributes:
        question: The question; empty when the open question is withdrawn.
        choices: The possible answers; the first is the expected one.
    """

    question: str
    choices: tuple[str, ...]


class WakeAt(NamedTuple):
    """The next deadline: without an event nothing changes before ``at_s``; infinite: never."""

    at_s: float


class Ended(NamedTuple):
    """The run has ended, after the safe stop.

    Attributes:
        outcome: How it ended.
        message: Why, in one sentence.
        end: Name of the mission's end; empty if it ended otherwise.
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
