"""Arrays of setpoints from their submission to their echo: a stream in which the newest wins.

One array is under way at a time, and the newest of those submitted meanwhile waits. It is written
as soon as the one under way has been echoed, or its echo is overdue; nothing older is written
after it.

Each writing of an array has a number of its own (its *wire id*), so that an echo tells which one
it answers. An echo with other values, or with a number that nobody wrote, means damage on one of
the two ways: the array is written again at once.

The array in force is repeated while nothing else is written (*refreshed*), so that the firmware's
dead man's switch sees that the line is alive. Nobody waits for the echo of a refresh.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

from pirate_sm.backends.serial.link.line_quality import NEVER, LineQuality, Refreshing
from pirate_sm.backends.serial.link.wire_slots import Integers, WireSlot, to_counts, why_refused
from pirate_sm.model.events import FaultReport, SubmitResult, SubmitStatus
from pirate_sm.model.fault_codes import BuiltInFault
from pirate_sm.rosserial.messages import Array

BUDGET = 8
"""Times the longest wait for an echo: after this long an array's fate is called unknown."""

_REPEAT_BUDGET = 5
"""Times as long is tried to confirm again what had been confirmed before."""

_HURRY = 0.6
"""Copies of one array follow each other after this share of the time between two arrays."""

_REMEMBERED = 64


@dataclass
class _WantedArray:
    """An array that is to be in force."""

    setpoint_id: int
    counts: Integers
    since_s: float


@dataclass
class _ArrayUnderWay:
    """An array that is being written.

    Attributes:
        told: Its fate has been told; what is left is to see its last copy confirmed.
        needed: It must be confirmed all the same: the device may have forgotten it.
        again: It must be written again.
    """

    order: _WantedArray
    began_s: float
    told: bool = False
    needed: bool = False
    sent_s: float = -inf
    numbers: list[int] = field(default_factory=list)
    again: bool = True


class _Unanswered(NamedTuple):
    """A writing whose echo is not waited for; it still tells how good the line is.

    Attributes:
        at_s: When it was written.
        overtaken: Whether a newer array has taken its place; else it was a refresh.
    """

    at_s: float
    overtaken: bool = False


class SetpointLink:
    """Writes arrays until the device has echoed them.

    Args:
        slots: In the order of the wire.
        pack: Makes a payload of a wire id, counts and the mask of slots to be held.
        echo_within_s: An array not echoed for this long is written again; sooner where echoes have
            been seen to come sooner.
        spacing_s: The least time between two arrays.
        ids: How many wire ids there are; 0 is left to others.
        refreshing: How the array in force is repeated.

    Attributes:
        quality: Of the line.
        applied: Counts of the last array that was confirmed; None before.
        hold: One bit per slot that the firmware's switch shall keep; goes out with each writing.
        written: How many frames; ``damaged`` echoes among the answers; ``repeats`` among the
            frames, and ``refreshes``, for which no echo is awaited.
        trips: How often the firmware has reported that its switch has tripped.
    """

    def __init__(
        self,
        slots: Sequence[WireSlot],
        pack: Callable[[int, Sequence[int], int], bytes],
        *,
        echo_within_s: float,
        spacing_s: float,
        ids: int = 1 << 32,
        refreshing: Refreshing = NEVER,
    ) -> None:
        self._slots = tuple(slots)
        self._pack = pack
        self._longest_s = echo_within_s
        self._spacing_s = spacing_s
        self._ids = ids
        self._number = 0
        self._waiting: _WantedArray | None = None
        self._flight: _ArrayUnderWay | None = None
        self._latest: _WantedArray | None = None
        self._sent_s = -inf
        self.quality = LineQuality(echo_within_s)
        self._recent: dict[int, tuple[Array, float]] = {}
        self._refreshing = refreshing
        self._unanswered: dict[int, _Unanswered] = {}
        self._tripped = False
        self._results: list[SubmitResult | FaultReport] = []
        self.applied: Integers | None = None
        self.hold = 0
        self.written = 0
        self.damaged = 0
        self.repeats = 0
        self.refreshes = 0
        self.trips = 0

    # --- what is wanted ---------------------------------------------------------------------

    def submit(self, setpoint_id: int, values: Sequence[float], now: float) -> None:
        """Let the array wait to be written, in place of one that waits; or reject it.

        The one that waited ends as ``superseded``. An array under way goes on until its echo comes
        or is overdue: then it ends as ``accepted`` or ``unknown``, and the newest is written.
        """
        refusal = why_refused(self._slots, values)
        if refusal:
            self._tell(setpoint_id, "rejected", refusal)
            return
        older = self._waiting
        if older is not None:
            self._tell(
                older.setpoint_id, "superseded", f"array {setpoint_id} came before it was sent"
            )
        self._waiting = _WantedArray(setpoint_id, to_counts(self._slots, values), now)

    def reassert(self, now: float) -> None:
        """Have the last array written again: the device may have forgotten it."""
        if self._flight is not None:
            self._flight.again, self._flight.began_s = True, now
        elif self._latest is not None and self._waiting is None:
            order = _WantedArray(self._latest.setpoint_id, self._latest.counts, now)
            self._flight = _ArrayUnderWay(order, now, told=True, needed=True)

    # --- what is written --------------------------------------------------------------------

    @property
    def idle(self) -> bool:
        """Whether nothing waits and nothing is unanswered."""
        return self._waiting is None and self._flight is None

    @property
    def in_force(self) -> Integers | None:
        """The array that the device has, as far as is known: last confirmed, else last written."""
        if self.applied is not None:
            return self.applied
        return self._latest.counts if self._latest is not None else None

    @property
    def due_s(self) -> float:
        """When an array is to be written or given up."""
        flight, waiting = self._flight, self._waiting
        if flight is not None and not (flight.told and waiting is not None):
            return -inf if flight.again else flight.sent_s + self._patience_s
        if waiting is not None:
            return self._sent_s + self._gap_s
        return self._refresh_s

    @property
    def _refresh_s(self) -> float:
        """When the array in force is to be repeated; infinite where nothing was ever written."""
        if self._latest is None:
            return inf
        return self._sent_s + (self._gap_s if self._tripped else self._refresh_every_s)

    @property
    def _refresh_every_s(self) -> float:
        """How long after the last writing the array in force is repeated."""
        lost = self.quality.lost_one_way
        return self._refreshing.interval_s(lost, _HURRY * self._spacing_s)

    @property
    def _gap_s(self) -> float:
        """How long after the last writing a different array may be written."""
        return _HURRY * self._spacing_s if self.quality.bad else self._spacing_s

    @property
    def _patience_s(self) -> float:
        """How long to wait for an echo before the next writing.

        Once one is late it is as good as lost. Where many are lost, waiting costs more than it
        saves: then copies follow each other as fast as the line and the ring of the receiver
        allow, still one at a time in there.
        """
        flight = self._flight
        if flight is not None and not flight.told and (self.quality.bad or len(flight.numbers) > 1):
            return _HURRY * self._spacing_s
        return min(self.quality.patience_s, self._refresh_every_s)

    def expire(self, now: float, able: bool = True) -> None:
        """Give up, or have written again, what has been awaited for long enough.

        Args:
            now: The time.
            able: Whether anything can be written at all.
        """
        flight, waiting = self._flight, self._waiting
        if flight is not None and flight.told and waiting is not None:
            flight = self._flight = None  # what comes now is in force instead
        budget_s = BUDGET * self._longest_s
        if flight is not None and flight.numbers and now >= flight.sent_s + self._patience_s:
            patience_s = budget_s * (_REPEAT_BUDGET if flight.needed else 1)
            if waiting is not None:
                self._overtake(flight, waiting)
            elif now >= flight.began_s + patience_s:
                self.quality.lose(1.0)
                self._end(flight, f"no echo after {len(flight.numbers)} copies")
            else:
                flight.again = True
        self._miss(now)
        if able:
            return
        flight = self._flight
        if flight is not None and now >= flight.began_s + budget_s:
            self._end(flight, "the link is down")
        if waiting is not None and now >= waiting.since_s + budget_s:
            self._waiting, self._latest = None, waiting  # to be repeated should the link return
            self._tell(waiting.setpoint_id, "unknown", "the link is down")

    def next_payload(self, now: float) -> bytes:
        """Return the payload to be written now, counted as written; empty when there is none."""
        flight = self._flight
        if flight is not None and flight.again and self._waiting is not None:
            # A repeat would come after something newer is wanted.
            self._overtake(flight, self._waiting)
            flight = None
        if flight is None and self._waiting is not None and now >= self._sent_s + self._gap_s:
            flight = self._flight = _ArrayUnderWay(self._waiting, now)
            self._waiting = None
        if flight is None:
            return self._refresh(now) if self._waiting is None else b""
        if not flight.again:
            return b""
        self.repeats += bool(flight.numbers) or flight.told
        flight.again, flight.sent_s = False, now
        self._latest = flight.order
        payload = self._write(flight.order, now)
        flight.numbers.append(self._number)
        return payload

    def _refresh(self, now: float) -> bytes:
        """Return the payload of the array in force once more, if that is due."""
        if self._latest is None or now < self._refresh_s:
            return b""
        self.refreshes += 1
        payload = self._write(self._latest, now)
        self._unanswered[self._number] = _Unanswered(now)
        return payload

    def _write(self, order: _WantedArray, now: float) -> bytes:
        """Return the payload of this array, under a number of its own."""
        self._number = self._number % (self._ids - 1) + 1
        self._recent[self._number] = Array(self._number, order.counts, self.hold), now
        if len(self._recent) > min(_REMEMBERED, self._ids // 2):
            del self._recent[next(iter(self._recent))]
        self._sent_s, self._tripped = now, False
        self.written += 1
        return self._pack(self._number, order.counts, self.hold)

    def _miss(self, now: float) -> None:
        """Count writings as lost whose echo is overdue and is not waited for."""
        limit_s = now - self._longest_s
        for number in [n for n, each in self._unanswered.items() if each.at_s <= limit_s]:
            del self._unanswered[number]
            self.quality.lose(1.0)

    # --- what is answered -------------------------------------------------------------------

    def echoed(self, number: int, counts: Integers, now: float, hold: int | None = None) -> None:
        """Take in an echo: the device says what it has applied.

        Args:
            number: Of the writing that it answers.
            counts: What is in force.
            now: The time.
            hold: The mask that came with it; None where the echo has no field for it.
        """
        flight = self._flight
        written, at_s = self._recent.get(number, (None, now))
        if written is None or (hold is not None and hold != written.hold):
            self._correct(now)
            return
        if written.counts != counts:
            if counts == written.tripped.counts:
                self.trips += 1
                self._tripped = True  # written again as soon as the line allows
            else:
                self._correct(now)
            return
        unanswered = self._unanswered.pop(number, None)
        if unanswered is not None:
            self.quality.lose(0.0)
            if unanswered.overtaken:
                self.quality.learn(now - at_s)
        if flight is None or number not in flight.numbers:
            return  # of an array that has been given up, or one more copy of one accepted
        self.applied = counts
        place = flight.numbers.index(number)
        self.quality.learn(now - at_s)
        self.quality.lose(place / (place + 1))
        if not flight.told:
            flight.told, flight.began_s = True, now
            self._tell(flight.order.setpoint_id, "accepted", "")
        if number == flight.numbers[-1]:
            self._flight = None
        else:
            del flight.numbers[: place + 1]  # only later copies can still say something new

    def unreadable(self, now: float) -> None:
        """Take in an echo that cannot be read."""
        self._correct(now)

    def take(self) -> list[SubmitResult | FaultReport]:
        """Return what has become of arrays since the last call."""
        results, self._results = self._results, []
        return results

    def _correct(self, now: float) -> None:
        """Have the array written again: something else may be in force."""
        self.damaged += 1
        if self._flight is not None:
            self._flight.again = True
        else:
            self.reassert(now)

    def _overtake(self, flight: _ArrayUnderWay, newer: _WantedArray) -> None:
        """Give an array up because a newer one waits; its echo may still come."""
        for number in flight.numbers:
            if number in self._recent:
                self._unanswered[number] = _Unanswered(self._recent[number][1], overtaken=True)
        self._end(flight, f"array {newer.setpoint_id} came before its echo")

    def _end(self, flight: _ArrayUnderWay, reason: str) -> None:
        self._flight = None
        if not flight.told:
            self._tell(flight.order.setpoint_id, "unknown", reason)
        elif flight.needed and self._waiting is None:
            message = "the setpoints in force could not be confirmed again"
            self._results.append(BuiltInFault.LINK_NO_ECHO.report(message))

    def _tell(self, setpoint_id: int, status: SubmitStatus, reason: str) -> None:
        self._results.append(SubmitResult(setpoint_id, status, reason))
