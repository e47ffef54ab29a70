"""Events: the closed set of the engine's inputs.

Every input of a run is one of these, so a recording of them can be replayed exactly. Time is not
part of an event: the engine receives it separately, in seconds since the run began.
``ALPHABET_VERSION`` changes with every change of a class or field here or in
:mod:`pirate_sm.core.effects`, and with every change of the engine's results for the same
events.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isnan, nan
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

ALPHABET_VERSION = 12

READABLE_ALPHABETS = (5, 6, 7, 8, 9, 10, 11, 12)
"""Recordings of these are read: 6 has an event more than 5."""

EVIDENCE_ENDS = 10
"""Since this alphabet belief ends with its evidence. Older recordings replay by their own rules."""

SubmitStatus: TypeAlias = Literal["accepted", "superseded", "rejected", "unknown"]


class Tick(NamedTuple):
    """Time has passed; deadlines may be due."""


class SensorFrame(NamedTuple):
    """One board has reported its raw channel values.

    Attributes:
        board: Id of the board, as in the robot's profile.
        values: Raw values in the order of the board's channels; NaN for a silent channel.
    """

    board: int
    values: tuple[float, ...]


class DetectorWord(NamedTuple):
    """A detector has reported a word, which is valid for ``valid_for_s`` or until the next one.

    Attributes:
        by: Where an operator has said it, such as ``page``; empty for a detector and a keyboard.
    """

    word: str
    valid_for_s: float
    by: str = ""


class EnvironmentReport(NamedTuple):
    """An outside source has reported the pipe around the robot.

    What it knows counts in place of what the engine derives from its signals, for as long as it is
    valid; what it does not know the engine goes on deriving.

    Attributes:
        segment: See :class:`pirate_sm.core.effects.Environment`, also for all other fields but the
            next.
        valid_for_s: How long it is valid, or until the next report; infinite: until then.
    """

    segment: str
    roll_rad: float
    pitch_rad: float
    diameter_m: float
    valid_for_s: float = inf
    joint: str = ""
    junction: str = ""
    opening_roll_rad: float = nan
    distance_m: float = nan
    diameter_ahead_m: float = nan
    run: str = ""
    arc_m: float = nan


class OutsideNumber(NamedTuple):
    """Somebody outside the robot has measured one of its outside signals.

    Attributes:
        signal: Its name in the profile.
        value: In SI; NaN is unknown.
        age_s: How long ago it was measured; it is taken off the validity.
    """

    signal: str
    value: float
    age_s: float = 0.0


class SubmitResult(NamedTuple):
    """The final result of a setpoint array.

    Attributes:
        setpoint_id: Id of the array.
        status: ``accepted``: the robot has it. ``superseded``: a newer array replaced it before
            it was sent. ``rejected``: it was never sent. ``unknown``: it may have been applied.
        reason: Why, in words; empty when accepted.
    """

    setpoint_id: int
    status: SubmitStatus
    reason: str = ""


class FaultReport(NamedTuple):
    """A backend has found something wrong, e.g. ``link.lost``.

    A report with code and message of one of the robot's fault rules counts as raised by that rule,
    and denies the same clamps.

    Attributes:
        away_s: How long the controller was silent that is back; NaN if nobody knows.
        of: The boards, joints, wheels and parts that it is a fault of; empty: nobody's.
    """

    code: str
    message: str
    away_s: float = nan
    of: tuple[str, ...] = ()


class OperatorCommand(NamedTuple):
    """The operator gives a command that is not part of the mission.

    Attributes:
        command: Its name.
        share: By how much the duties of wheels are multiplied, so that the robot drives slower.
        at_once: Whether a command that stops the wheels ends another one of the operator that is
            under way while the robot drives.
    """

    command: str
    share: float = 1.0
    at_once: bool = False


class Observation(NamedTuple):
    """A person says where the robot is or what they see there; it changes nothing of the robot.

    Attributes:
        text: What they see, such as ``crack, 3 o'clock``; empty where they only say the place.
        place_m: Where the first wheel is along the route; NaN is unknown.
    """

    text: str
    place_m: float = nan

    @property
    def words(self) -> str:
        """Return it in words."""
        place = "an unknown place" if isnan(self.place_m) else f"{self.place_m:.2f} m"
        return f"seen at {place}: {self.text}" if self.text else f"wheel 1 is at {place}"


class Answer(NamedTuple):
    """The operator has chosen one of the possible answers."""

    choice: str


class Pause(NamedTuple):
    """The operator pauses the mission, with the wheels stopped.

    Attributes:
        by: Where it was asked for, such as ``page``; empty for a keyboard and a panel.
    """

    by: str = ""


class Resume(NamedTuple):
    """The operator resumes a paused mission.

    Attributes:
        by: Where it was asked for, such as ``page``; empty for a keyboard and a panel.
        until: The place before which it pauses again, once, as in :class:`Breakpoints`; empty for
            none.
    """

    by: str = ""
    until: str = ""


class Step(NamedTuple):
    """The operator lets a paused mission execute one step and pause again.

    Attributes:
        by: Where it was asked for, such as ``page``; empty for a keyboard and a panel.
    """

    by: str = ""


class Breakpoints(NamedTuple):
    """The operator chooses before which instructions the mission pauses, instead of earlier ones.

    Before the start of a run it is among what the engine has seen.

    Attributes:
        at: Places of instructions, ``file:line:col``.
        by: Where it was asked for, as in :class:`Pause`.
    """

    at: tuple[str, ...] = ()
    by: str = ""


class GoTo(NamedTuple):
    """The operator resumes a paused mission at the beginning of one of its phases.

    Attributes:
        phase: The phase.
        states: State of each region when the phase was found to be possible.
        unconfirmed: Regions that were unconfirmed then.
        by: Where it was asked for, as in :class:`Pause`.
        until: As in :class:`Resume`.
    """

    phase: str
    states: tuple[str, ...]
    unconfirmed: tuple[str, ...] = ()
    by: str = ""
    until: str = ""


class Skip(NamedTuple):
    """The operator skips the present wait, command or question.

    Attributes:
        trigger: In a wait, the name of the trigger to fire; empty for the first one.
    """

    trigger: str = ""


class SignalReport(NamedTuple):
    """A script provides signals and words in a run without sensors and detector.

    It takes effect with the next event, as if both came at the same time.

    Attributes:
        numbers: Signals by name in SI, NaN for unknown; other signals keep their values.
        words: The detector's word and the segment by name; None for unknown.
    """

    numbers: tuple[tuple[str, float], ...] = ()
    words: tuple[tuple[str, str | None], ...] = ()


class CommandFailed(NamedTuple):
    """A script lets the command under way fail, in a run without sensors."""

    reason: str


class Abort(NamedTuple):
    """The run must end now with the safe stop."""

    reason: str


Request: TypeAlias = (
    OperatorCommand
    | Observation
    | Answer
    | Pause
    | Resume
    | Step
    | Breakpoints
    | GoTo
    | Skip
    | Abort
)
"""A request of the operator, or of a program in place of an operator."""

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


class Rows(Protocol):
    """Rows of values, as a list of lists or an array has them."""

    def __getitem__(self, at: int, /) -> Any:
        """Return a row."""


@dataclass(frozen=True, eq=False)
class FrameBlock:
    """Reports of boards that came one after the other, with nothing in between.

    Attributes:
        times_s: When each was received, in seconds since the run began; never decreasing.
        boards: Id of the board of each.
        values: The raw values of each, in a row; rows are as long as the longest report.
        widths: Number of values that a board reports, by its id.
    """

    times_s: Sequence[float]
    boards: Sequence[int]
    values: Rows
    widths: Mapping[int, int]

    def __len__(self) -> int:
        """Return how many reports there are."""
        return len(self.times_s)

    def frames(self) -> Iterator[tuple[float, SensorFrame]]:
        """Yield the time and the frame of each report, in order."""
        for at, now_s in enumerate(self.times_s):
            yield now_s, self.frame(at)

    def frame(self, at: int) -> SensorFrame:
        """Return one of the frames."""
        board = self.boards[at]
        return SensorFrame(board, tuple(map(float, self.values[at][: self.widths[board]])))
