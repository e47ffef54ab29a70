"""Decides how a silent link is brought back to a known state, and when it is given up.

Pure: received frames and the time go in, requests and verdicts come out. The safe array stops
the robot; its echoes show whether the robot is known to be stopped.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence, Set
from dataclasses import dataclass, field
from math import inf

from pirate_sm.core.events import BuiltInFault, FaultReport, SensorFrame
from pirate_sm.robot.backends.serial.link.link_plan import Integers
from pirate_sm.robot.rosserial.messages import SetpointCodec

# --- outages --------------------------------------------------------------------------------------


BRIEF = 0.75
"""Share of ``silent_after``: a shorter silence that ends by itself is no outage."""

_UNCONFIRMED = "does not confirm the safe setpoints"
_BOARDS_WITHIN_S = 1.0
_SAFE_AGAIN_S = 0.1
_IN_ALL = 3
"""Times the budget after which a controller that comes and goes again and again is given up."""


@dataclass
class Outage:
    """A silence during which the mission is held.

    Attributes:
        heard_s: When the last frame before it came.
        since_s: Since when the mission is held.
        sign_s: The last sign of life.
        gone: Why the port went away; empty if it did not.
        anew: Whether the controller had to be asked anew.
        answered_s: When it first spoke again; infinite before.
        back_s: Since when it speaks again; infinite before, and while it is silent once more.
        silence_s: How long it was silent.
        safe_s: When the safe array was confirmed since; infinite before.
        stopped: Whether the safe array has been confirmed at all.
        wrote_s: When the safe array was last written.
        missing: Boards that reported before the silence but not since.
        frames: The last frame of each board since.
    """

    heard_s: float
    since_s: float
    sign_s: float
    gone: str = ""
    anew: bool = False
    answered_s: float = inf
    back_s: float = inf
    silence_s: float = 0.0
    safe_s: float = inf
    stopped: bool = False
    wrote_s: float = -inf
    missing: set[int] = field(default_factory=set)
    frames: dict[int, SensorFrame] = field(default_factory=dict)

    @property
    def back(self) -> bool:
        """Whether the controller speaks again and its topics are known."""
        return self.back_s < inf

    def relapse(self) -> None:
        """Handle a relapse: the controller is silent again, and what was known no longer holds."""
        self.back_s = self.safe_s = inf
        self.wrote_s = -inf
        self.frames.clear()

    def return_(self, now: float, boards: Set[int], safe_needed: bool) -> None:
        """Handle the controller's return; its boards and the safe array are awaited."""
        self.back_s = now
        self.answered_s = min(self.answered_s, now)
        self.silence_s = self.silence_s or now - self.heard_s
        self.safe_s = inf if safe_needed else now
        self.missing = set(boards)

    def confirm(self, now: float) -> None:
        """Handle that the safe array is in force."""
        if self.back:
            self.safe_s, self.stopped = min(self.safe_s, now), True

    @property
    def dumb(self) -> bool:
        """Whether the controller answers but no board reports."""
        return bool(self.missing) and not self.frames

    def report(self, frame: SensorFrame) -> None:
        """Take in a board's frame since the controller's return."""
        self.frames[frame.board] = frame
        self.missing.discard(frame.board)


class Recovery:
    """Decides how an outage ends.

    Args:
        brief_s: A shorter silence that ends by itself is no outage.
        within_s: How long after the last sign of life the link may take to return.
        advice: What a person can do when no board reports, from the profile.
    """

    def __init__(self, brief_s: float, within_s: float, advice: str) -> None:
        self._advice = advice
        self.brief_s = brief_s
        self._within_s = within_s

    def is_brief(self, outage: Outage, awake_s: float) -> bool:
        """Return whether the silence was too short to be an outage.

        Args:
            outage: The silence.
            awake_s: How long it lasted while this program was awake.
        """
        return not (outage.gone or outage.anew) and awake_s < self.brief_s

    def wants_safe(self, outage: Outage, now: float) -> bool:
        """Return whether the safe array is due to be written."""
        return outage.back and outage.safe_s == inf and now >= outage.wrote_s + _SAFE_AGAIN_S

    def due_s(self, outage: Outage) -> float:
        """Return when there is something to do or to decide, if nothing comes before."""
        if not outage.back:
            dumb_s = outage.answered_s + self._within_s if outage.dumb else inf
            return min(self.gives_up_s(outage), dumb_s)
        if outage.safe_s == inf:
            return min(outage.wrote_s + _SAFE_AGAIN_S, outage.back_s + self._within_s)
        if outage.dumb:
            return outage.answered_s + self._within_s
        return outage.safe_s + _BOARDS_WITHIN_S if outage.missing else -inf

    def verdict(self, outage: Outage, now: float, stopped: bool) -> FaultReport | None:
        """Return the fault that the outage turned out to be; None while that is not clear.

        Args:
            outage: The outage.
            now: The time.
            stopped: Whether there was a safe array to be confirmed.
        """
        if outage.dumb and now >= outage.answered_s + self._within_s:
            return self._dumb(outage)
        if not outage.back:
            return self._given_up(outage, now) if now >= self.gives_up_s(outage) else None
        if outage.safe_s == inf:
            return self._unconfirmed(outage) if now >= outage.back_s + self._within_s else None
        if outage.dumb or (outage.missing and now < outage.safe_s + _BOARDS_WITHIN_S):
            return None
        return self._recovered(outage, stopped)

    def gives_up_s(self, outage: Outage) -> float:
        """Return when a lasting silence is given up as a lost link."""
        return min(outage.sign_s + self._within_s, outage.since_s + _IN_ALL * self._within_s)

    def _given_up(self, outage: Outage, now: float) -> FaultReport:
        away_s = now - outage.heard_s
        if outage.gone:
            message = f"the link to the robot is lost: {outage.gone}, and was not back"
            return BuiltInFault.LINK_LOST.report(f"{message} {away_s:.1f} s later")
        message = f"the robot's controller has been silent for {away_s:.1f} s"
        return BuiltInFault.LINK_SILENT.report(f"{message}, however often it was asked")

    def _dumb(self, outage: Outage) -> FaultReport:
        what = "the robot's controller answers but none of its boards reports any more"
        if not outage.stopped:
            what = f"{what}, and it {_UNCONFIRMED}"
        return BuiltInFault.LINK_SILENT.report(f"{what}: {self._advice}")

    def _unconfirmed(self, outage: Outage) -> FaultReport:
        back = f"the robot's controller is back after {outage.silence_s:.1f} s of silence"
        return BuiltInFault.LINK_NO_ECHO.report(f"{back} and {_UNCONFIRMED}")

    def _recovered(self, outage: Outage, stopped: bool) -> FaultReport:
        away_s = outage.silence_s
        state = (
            "it has confirmed that the safe setpoints have arrived"
            if stopped
            else "nothing had been sent to it before"
        )
        if outage.gone:
            what = f"the link was away for {away_s:.1f} s ({outage.gone}) and is back"
            return BuiltInFault.LINK_INTERRUPTED.report(f"{what}: {state}", away_s)
        return BuiltInFault.FIRMWARE_RESET.report(f"{was_reset(away_s)}: {state}", away_s)


def was_reset(silence_s: float) -> str:
    """Return the sentence about a controller that speaks again.

    Where answers get lost, nobody can know whether the controller spoke because it was asked or of
    its own accord. What a reset requires is right after any silence.
    """
    return f"the robot's controller said nothing for {silence_s:.1f} s, it was reset or hung"


# --- the safe array -------------------------------------------------------------------------------


SAFE_WIRE_ID = 0
"""The wire id of the safe array; no other array has it."""


class SafeArray:
    """Makes the payload of the safe array.

    Args:
        codec: The codec of arrays.
        zero: Slots that are zero in the safe state.
        slots: How many slots there are.

    Attributes:
        kept: One bit per slot that the firmware's dead man's switch keeps.
        held: Values to hold, where they differ from those in force.
        counts: The last safe array that was made.
    """

    def __init__(self, codec: SetpointCodec, zero: Collection[int], slots: int) -> None:
        self._codec = codec
        self._zero = frozenset(zero)
        self._source: Integers | None = None
        self._payload = b""
        self.kept = sum(1 << at for at in range(slots) if at not in self._zero)
        self.held: Integers | None = None
        self.counts: Integers = ()

    def payload(self, in_force: Integers) -> bytes:
        """Return the payload for the array in force."""
        source = self.held if self.held is not None else in_force
        if source is not self._source:  # cached, for it is needed at every turn
            self._source = source
            self.counts = tuple(0 if at in self._zero else each for at, each in enumerate(source))
            self._payload = self._codec.pack(SAFE_WIRE_ID, self.counts, self.kept)
        return self._payload


# --- the stop -------------------------------------------------------------------------------------


class StopConfirmation:
    """Follows the arrays that are written and their echoes.

    Args:
        slots: Slots that are zero in the safe state.

    Attributes:
        confirmed: Whether the last array that drove a slot was followed by one that drives none and
            has been echoed. True while nothing has been driven.
    """

    def __init__(self, slots: Collection[int]) -> None:
        self._slots = tuple(slots)
        self._since: set[int] = set()
        self.confirmed = True

    def wrote(self, number: int, counts: Sequence[int]) -> None:
        """Take in an array that was written, with its number."""
        if any(counts[slot] for slot in self._slots):
            self.confirmed = False
            self._since.clear()
        else:
            self._since.add(number)

    def echoed(self, number: int, counts: Sequence[int]) -> None:
        """Take in an echo: the values that the device has applied."""
        if any(counts[slot] for slot in self._slots):
            self.confirmed = False
        elif number in self._since:
            self.confirmed = True
