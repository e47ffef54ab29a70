"""Arrays of setpoints from their submission to their echo: a stream in which the newest wins.

One array is under way at a time. Of the arrays submitted meanwhile the newest waits. It is written
as soon as the one under way has been echoed or its echo is overdue. Nothing older is written after
it.

Each writing of an array has its own number (its *wire id*), so an echo shows which writing it
answers. An echo with other values, or with a number that was never written, means that one of the
two directions was damaged; the array is then written again at once.

The array in force is repeated while nothing else is written (*refreshed*), so that the firmware's
dead man's switch knows that the line is alive. Nothing waits for the echo of a refresh; but if none
comes for long, the array in force is sent again like a new one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

from pirate_sm.core.events import BuiltInFault, FaultReport, SubmitResult, SubmitStatus
from pirate_sm.robot.backends.serial.link.health import NEVER, LineQuality, Refreshing
from pirate_sm.robot.backends.serial.link.link_plan import (
    Integers,
    WireSlot,
    to_counts,
    why_refused,
)
from pirate_sm.robot.rosserial.messages import Array

# --- arrays under way -----------------------------------------------------------------------------


@dataclass
class WantedArray:
    """An array that should come into force."""

    setpoint_id: int
    counts: Integers
    since_s: float


@dataclass
class ArrayUnderWay:
    """An array that is being written.

    Attributes:
        reported: Its result has been reported; only its last copy still has to be confirmed.
        needed: It must be confirmed again, because the device may have forgotten it.
        again: It must be written again.
    """

    order: WantedArray
    began_s: float
    reported: bool = False
    needed: bool = False
    sent_s: float = -inf
    numbers: list[int] = field(default_factory=list)
    again: bool = True


class Unanswered(NamedTuple):
    """A writing whose echo nothing waits for, but which still measures the line.

    Attributes:
        at_s: When it was written.
        overtaken: The array that a newer one has replaced; None for a refresh.
    """

    at_s: float
    overtaken: ArrayUnderWay | None = None


# --- the link -------------------------------------------------------------------------------------


BUDGET = 8
"""After this many times the longest wait for an echo, an array's result is ``unknown``."""

_REPEAT_BUDGET = 5
"""An array that had been confirmed before is given this many times as long."""

_REFRESH_BUDGET = 2
"""An array in force whose refreshes are not echoed for this many times as long is sent again."""

_HURRY = 0.6
"""The share of the least time between two arrays after which a copy may follow."""

_REMEMBERED = 64


class SetpointLink:
    """Writes arrays until the device has echoed them.

    Args:
        slots: The slots, in the order of the wire.
        pack: Makes a payload from a wire id, counts and the mask of slots to hold.
        echo_within_s: An array not echoed for this long is written again. The time shrinks where
            echoes are faster.
        spacing_s: The least time between two arrays.
        ids: How many wire ids there are; 0 is reserved for others.
        refreshing: How the array in force is repeated.

    Attributes:
        quality: The measured quality of the line.
        applied: Counts of the last confirmed array; None before.
        hold: One bit per slot that the firmware's switch must keep; sent with each writing.
        written: Frames written. Of these, ``repeats`` were written again, and ``refreshes`` await
            no echo. ``damaged`` counts damaged echoes.
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
        self._waiting: WantedArray | None = None
        self._flight: ArrayUnderWay | None = None
        self._latest: WantedArray | None = None
        self._sent_s = -inf
        self._echoed_s = inf
        self.quality = LineQuality(echo_within_s)
        self._recent: dict[int, tuple[Array, float]] = {}
        self._refreshing = refreshing
        self._unanswered: dict[int, Unanswered] = {}
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
        """Queue an array instead of one that still waits, or reject it.

        The replaced array ends as ``superseded``. An array under way goes on until its echo comes
        or is overdue. It then ends as ``accepted`` or ``unknown``, and the newest is written.
        """
        refusal = why_refused(self._slots, values)
        if refusal:
            self._report(setpoint_id, "rejected", refusal)
            return
        older = self._waiting
        if older is not None:
            self._report(
                older.setpoint_id, "superseded", f"array {setpoint_id} came before it was sent"
            )
        self._waiting = WantedArray(setpoint_id, to_counts(self._slots, values), now)

    def reassert(self, now: float) -> None:
        """Write the last array again, because the device may have forgotten it."""
        if self._flight is not None:
            self._flight.again, self._flight.began_s = True, now
        elif self._latest is not None and self._waiting is None:
            order = WantedArray(self._latest.setpoint_id, self._latest.counts, now)
            self._flight = ArrayUnderWay(order, now, reported=True, needed=True)

    # --- what is written --------------------------------------------------------------------

    @property
    def idle(self) -> bool:
        """Whether no array waits and every written one has its result."""
        return self._waiting is None and self._flight is None

    @property
    def in_force(self) -> Integers | None:
        """The array that the device has, as far as known: last confirmed, else last written."""
        if self.applied is not None:
            return self.applied
        return self._latest.counts if self._latest is not None else None

    @property
    def confirmed(self) -> Integers | None:
        """The array in force if it is known for sure: the last one wanted, written and echoed."""
        latest = self._latest.counts if self._latest is not None else None
        return self.applied if self.idle and self.applied == latest else None

    @property
    def due_s(self) -> float:
        """When an array is due to be written or given up."""
        flight, waiting = self._flight, self._waiting
        if flight is not None and not (flight.reported and waiting is not None):
            return -inf if flight.again else flight.sent_s + self._patience_s
        if waiting is not None:
            return self._sent_s + self._gap_s
        return self._refresh_s

    @property
    def _refresh_s(self) -> float:
        """When the array in force is to be repeated; infinite before the first array."""
        if self._latest is None:
            return inf
        return self._sent_s + (self._gap_s if self._tripped else self._refresh_every_s)

    @property
    def _refresh_every_s(self) -> float:
        """The time from the last writing to the next refresh."""
        lost = self.quality.lost_one_way
        return self._refreshing.interval_s(lost, _HURRY * self._spacing_s)

    @property
    def _gap_s(self) -> float:
        """The least time from the last writing to that of a different array."""
        return _HURRY * self._spacing_s if self.quality.bad else self._spacing_s

    @property
    def _patience_s(self) -> float:
        """The time to wait for an echo before the next writing.

        An echo that is late is most likely lost. On a bad line waiting costs more than it saves.
        Copies then follow each other as fast as the line and the receiver's ring allow; the ring
        still holds one at a time.
        """
        flight = self._flight
        if (
            flight is not None
            and not flight.reported
            and (self.quality.bad or len(flight.numbers) > 1)
        ):
            return _HURRY * self._spacing_s
        return min(self.quality.patience_s, self._refresh_every_s)

    def expire(self, now: float, able: bool = True) -> None:
        """Give up or repeat the array whose echo is overdue.

        Args:
            now: The time.
            able: Whether the port can be written to.
        """
        flight, waiting = self._flight, self._waiting
        if flight is not None and flight.reported and waiting is not None:
            flight = self._flight = None  # the waiting array replaces it
        budget_s = BUDGET * self._longest_s
        if (
            flight is not None
            and flight.numbers
            and (now >= flight.sent_s + self._patience_s or (flight.again and waiting is None))
        ):
            # A wrong echo asks for another copy each time, so that none would ever be overdue.
            patience_s = budget_s * (_REPEAT_BUDGET if flight.needed else 1)
            if waiting is not None:
                self._overtake(flight, waiting)
            elif now >= flight.began_s + patience_s:
                self.quality.lose(1.0)
                self._end(flight, f"no echo after {len(flight.numbers)} copies")
            else:
                flight.again = True
        quiet = self.idle and self._unanswered
        self._miss(now)
        if quiet and now >= self._echoed_s + _REFRESH_BUDGET * budget_s:
            self.reassert(now)
        if able:
            return
        flight = self._flight
        if flight is not None and now >= flight.began_s + budget_s:
            self._end(flight, "the link is down")
        if waiting is not None and now >= waiting.since_s + budget_s:
            self._waiting, self._latest = None, waiting  # to be repeated when the link returns
            self._report(waiting.setpoint_id, "unknown", "the link is down")

    def next_payload(self, now: float) -> bytes:
        """Return the payload to write now and count it as written; empty if none is due."""
        flight = self._flight
        if flight is not None and flight.again and self._waiting is not None:
            # A repeat would overwrite the newer array.
            self._overtake(flight, self._waiting)
            flight = None
        if flight is None and self._waiting is not None and now >= self._sent_s + self._gap_s:
            flight = self._flight = ArrayUnderWay(self._waiting, now)
            self._waiting = None
        if flight is None:
            return self._refresh(now) if self._waiting is None else b""
        if not flight.again:
            return b""
        self.repeats += bool(flight.numbers) or flight.reported
        flight.again, flight.sent_s = False, now
        self._latest = flight.order
        payload = self._write(flight.order, now)
        flight.numbers.append(self._number)
        return payload

    def _refresh(self, now: float) -> bytes:
        """Return the payload of the array in force again; empty if that is not due."""
        if self._latest is None or now < self._refresh_s:
            return b""
        self.refreshes += 1
        payload = self._write(self._latest, now)
        self._unanswered[self._number] = Unanswered(now)
        return payload

    def _write(self, order: WantedArray, now: float) -> bytes:
        """Return the payload of this array under a new number, and remember it."""
        self._number = self._number % (self._ids - 1) + 1
        self._recent[self._number] = Array(self._number, order.counts, self.hold), now
        if len(self._recent) > min(_REMEMBERED, self._ids // 2):
            del self._recent[next(iter(self._recent))]
        self._sent_s, self._tripped = now, False
        self.written += 1
        return self._pack(self._number, order.counts, self.hold)

    def _miss(self, now: float) -> None:
        """Count refreshes and overtaken arrays as lost whose echo is overdue."""
        limit_s = now - self._longest_s
        for number in [n for n, each in self._unanswered.items() if each.at_s <= limit_s]:
            older = self._unanswered.pop(number).overtaken
            self.quality.lose(1.0)
            if older is not None and not older.reported and number == older.numbers[-1]:
                older.reported = True
                self._report(
                    older.order.setpoint_id,
                    "unknown",
                    "a newer array was sent before its echo came",
                )

    # --- what is answered -------------------------------------------------------------------

    def echoed(self, number: int, counts: Integers, now: float, hold: int | None = None) -> None:
        """Handle an echo, in which the device reports what it has applied.

        Args:
            number: The wire id of the writing that it answers.
            counts: The values in force.
            now: The time.
            hold: The mask in the echo; None if the echo has no field for it.
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
        self._echoed_s = now
        unanswered = self._unanswered.pop(number, None)
        if unanswered is not None:
            self.quality.lose(0.0)
            if unanswered.overtaken is not None:
                self.quality.learn(now - at_s)
                self._confirm_overtaken(unanswered.overtaken, counts)
        if flight is None or number not in flight.numbers:
            return  # of an array given up, or of another copy of an accepted one
        self.applied = counts
        place = flight.numbers.index(number)
        self.quality.learn(now - at_s)
        self.quality.lose(place / (place + 1))
        if not flight.reported:
            flight.reported, flight.began_s = True, now
            self._report(flight.order.setpoint_id, "accepted", "")
        later = flight.numbers[place + 1 :]
        if later and not (flight.needed and self._refresh_every_s < inf):
            flight.numbers[:] = later  # only these still matter: the last may arrive damaged
            return
        # The device has the array, and later copies only refresh it. If they follow each other
        # faster than a round trip, no echo is that of the last one. The next refresh replaces a
        # damaged one.
        self._unanswered |= {each: Unanswered(self._recent[each][1]) for each in later}
        self._flight = None

    def _confirm_overtaken(self, older: ArrayUnderWay, counts: Integers) -> None:
        """Report an array that was in force until the newer one came."""
        self.applied = counts
        if not older.reported:
            older.reported = True
            self._report(older.order.setpoint_id, "accepted", "")

    def unreadable(self, now: float) -> None:
        """Handle an echo that cannot be decoded."""
        self._correct(now)

    def take(self) -> list[SubmitResult | FaultReport]:
        """Return the results of arrays since the last call."""
        results, self._results = self._results, []
        return results

    def _correct(self, now: float) -> None:
        """Write the array again, because something else may be in force."""
        self.damaged += 1
        if self._flight is not None:
            self._flight.again = True
        else:
            self.reassert(now)

    def _overtake(self, flight: ArrayUnderWay, newer: WantedArray) -> None:
        """Wait no longer with a newer array; the result follows when the echo comes or is overdue.

        In a stream on a bad line a newer array always waits: without the late echoes nothing of it
        would ever be confirmed.
        """
        for number in flight.numbers:
            if number in self._recent:
                self._unanswered[number] = Unanswered(self._recent[number][1], flight)
        self._flight = None
        if not (flight.numbers and flight.numbers[-1] in self._unanswered):
            self._end(flight, f"array {newer.setpoint_id} came before its echo")

    def _end(self, flight: ArrayUnderWay, reason: str) -> None:
        self._flight = None
        if not flight.reported:
            self._report(flight.order.setpoint_id, "unknown", reason)
        elif flight.needed and self._waiting is None:
            message = "the setpoints in force could not be confirmed again"
            self._results.append(BuiltInFault.LINK_NO_ECHO.report(message))

    def _report(self, setpoint_id: int, status: SubmitStatus, reason: str) -> None:
        self._results.append(SubmitResult(setpoint_id, status, reason))
