"""Events: the closed set of what can happen to the engine.

Every input of a run is one of these; nothing else can change its course, so a recording of them
replays it. Time is not part of an event: it is handed to the engine beside it, in seconds since
the run began. ``ALPHABET_VERSION`` changes with any change of a field or a class here or in
:mod:`pirate_sm.model.effects`, and where the engine would make something else of the same events.
"""

from __future__ import annotations

from math import inf
from typing import Literal, NamedTuple, TypeAlias

ALPHABET_VERSION = 6

READABLE_ALPHABETS = (5, 6)
"""Recordings of these are read: 6 has an event more than 5."""

SubmitStatus: TypeAlias = Literal["accepted", "superseded", "rejected", "unknown"]


class Tick(NamedTuple):
    """Time has passed; deadlines may have come due."""


class SensorFrame(NamedTuple):
    """One board has reported its raw channel values.

    Attributes:
        board: Id of the board, as in the robot's profile.
        values: Raw values in the order of the board's channels; NaN where a channel is silent.
    """

    board: int
    values: tuple[float, ...]


class DetectorWord(NamedTuple):
    """A detector has said a word, a level that holds for ``valid_for_s`` or until the next."""

    word: str
    valid_for_s: float


class EnvironmentReport(NamedTuple):
    """Somebody outside has reported the pipe around the robot.

    The engine derives the same from its signals; a report counts instead while it is valid.

    Attributes:
        segment: ``Out``, ``Straight`` or ``Joint`` (thesis section 4-3-2); empty is unknown.
        roll_rad: Roll of the robot about the axis of the pipe, against the horizontal; NaN is
            unknown, as for the others.
        pitch_rad: Pitch of the pipe's axis, positive where it climbs ahead of the robot.
        diameter_m: Inner diameter, h + 2r (thesis eq. 3-2).
        valid_for_s: How long it is valid unless another one comes; infinite: until then.
    """

    segment: str
    roll_rad: float
    pitch_rad: float
    diameter_m: float
    valid_for_s: float = inf


class OutsideNumber(NamedTuple):
    """Somebody outside the robot has measured one of its outside signals.

    Attributes:
        signal: Its name in the profile.
        value: In SI; NaN is unknown.
    """

    signal: str
    value: float


class SubmitResult(NamedTuple):
    """A setpoint array has met its one and only fate.

    Attributes:
        setpoint_id: The id that the array was submitted under.
        status: ``accepted``: the robot has it. ``superseded``: a newer array replaced it before
            it was sent. ``rejected``: it was never sent. ``unknown``: it may have been applied.
        reason: Why, in words; empty when accepted.
    """

    setpoint_id: int
    status: SubmitStatus
    reason: str = ""


class FaultReport(NamedTuple):
    """A backend has found something wrong, e.g. ``link.lost``.

    With code and message of one of the robot's fault rules it is that rule's: it denies the clamps
    that the rule denies.
    """

    code: str
    message: str


class OperatorCommand(NamedTuple):
    """The operator asks for one command, outside the mission's own steps."""

    command: str


class Answer(NamedTuple):
    """The operator has chosen one of the answers that are on offer."""

    choice: str


class Pause(NamedTuple):
    """The operator wants the wheels stopped and the mission frozen."""


class Resume(NamedTuple):
    """The operator wants a paused mission to go on."""


class Step(NamedTuple):
    """The operator wants a paused mission to do its next step and pause again."""


class GoTo(NamedTuple):
    """The operator hands a paused mission back at the beginning of one of its phases.

    Attributes:
        phase: The phase.
        states: State of each region in which the phase has been found to be able to run.
        unconfirmed: Regions that were not confirmed then.
    """

    phase: str
    states: tuple[str, ...]
    unconfirmed: tuple[str, ...] = ()


class Skip(NamedTuple):
    """The operator passes over what the mission waits for.

    Attributes:
        trigger: In a wait, the name of the trigger to take; empty for the first one listed.
    """

    trigger: str = ""


class SignalReport(NamedTuple):
    """A script says what sensors and detector show, in a run where none of them speaks.

    It counts from the next event on, as if both came at one moment.

    Attributes:
        numbers: Signals by name in SI, NaN for unknown; the others stay as they are.
        words: The detector's word and the segment by name, None for unknown.
    """

    numbers: tuple[tuple[str, float], ...] = ()
    words: tuple[tuple[str, str | None], ...] = ()


class CommandFailed(NamedTuple):
    """A script says that the command under way will not be done, where no sensor can tell."""

    reason: str


class Abort(NamedTuple):
    """The run must end now, through the safe stop."""

    reason: str


Request: TypeAlias = OperatorCommand | Answer | Pause | Resume | Step | GoTo | Skip | Abort
"""What a person asks for, or who drives the engine in their place."""

Event: TypeAlias = (
    Tick
    | SensorFrame
    | DetectorWord
    | EnvironmentReport
    | OutsideNumber
    | SubmitResult
    | FaultReport
    | SignalReport
    | CommandFailed
    | Request
)
