"""Arrays of setpoints until they are echoed: one under way, none lost, none older after a newer.

Each writing of an array has a number of its own (its *wire id*), so that an echo tells which one
it answers. An echo with other values, or with a number that nobody wrote, means damage on one of
the two ways: the array is written again at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import NamedTuple

from pirate_sm.model.events import FaultReport, SubmitResult, SubmitStatus

Integers = tuple[int, ...]

BUDGET = 8
"""Times the longest wait for an echo: after so long an array's fate is called unknown."""

_REPEAT_BUDGET = 5
"""Times as long is tried to confirm again what had been confirmed before."""

_BAD = 0.25
"""Where more than this share is lost, the echo of not even the first writing is waited for."""

_HURRY = 0.6
"""Copies of one array follow each other after this share of the time between two arrays."""

_LOSS_GAIN = 1 / 16
_NOISE_BYTES = 2000
"""Over so many received bytes the share of damaged ones is taken: half a second of a busy line."""

_REMEMBERED = 64
_ROUNDING = 1e-6

NO_ECHO = "link.no_echo"

# How the time to wait for an echo follows what echoes have taken, as TCP's does (RFC 6298).
_MEAN_GAIN = 1 / 8
_SPREAD_GAIN = 1 / 4
_SPREADS = 4.0
_MARGIN_S = 0.01


class WireSlot(NamedTuple):
    """How one setpoint is written and what it may be, checked here independently.

    Attributes:
        resolution: Value of one count.
        limit: Largest magnitude, in the slot's own unit.
    """

    name: str
    resolution: float
    limit: float


@dataclass
class _Order:
    """An array that somebody wants in force."""

    setpoint_id: int
    counts: Integers
    since_s: float


@dataclass
class _Flight:
    """An array that is being written.

    Attributes:
        told: Its fate has been told; what is left is to see its last copy confirmed.
        needed: It must be confirmed all the same: the device may have forgotten it.
        again: It must be written again.
    """

    order: _Order
    began_s: float
    told: bool = False
    needed: bool = False
    sent_s: float = -inf
    numbers: list[int] = field(default_factory=list)
    again: bool = True


class SetpointLink:
    """Brings arrays to the device.

    Args:
        slots: In the order of the wire.
        pack: Makes a payload of a wire id and counts.
        echo_within_s: An array not echoed for so long is written again; sooner where echoes have
            been seen to come sooner.
        spacing_s: The least time between two arrays.
        ids: How many wire ids there are; 0 is left to others.

    Attributes:
        applied: Counts of the last array that was confirmed; None before.
        written: How many frames; ``damaged`` echoes among the answers; ``repeats`` among them.
    """

    def __init__(
        self,
        slots: Sequence[WireSlot],
        pack: Callable[[int, Sequence[int]], bytes],
        *,
        echo_within_s: float,
        spacing_s: float,
        ids: int = 1 << 32,
    ) -> None:
        self._slots = tuple(slots)
        self._pack = pack
        self._longest_s = echo_within_s
        self._mean_s = self._spread_s = echo_within_s / 2
        self._spacing_s = spacing_s
        self._ids = ids
        self._number = 0
        self._waiting: _Order | None = None
        self._flight: _Flight | None = None
        self._latest: _Order | None = None
        self._sent_s = -inf
        self._loss = self._noise = 0.0
        self._losses = 1
        self._recent: dict[int, tuple[Integers, float]] = {}
        self._results: list[SubmitResult | FaultReport] = []
        self.applied: Integers | None = None
        self.written = 0
        self.damaged = 0
        self.repeats = 0
        self.round_trips: deque[float] = deque(maxlen=1000)

    # --- what is wanted ---------------------------------------------------------------------

    def submit(self, setpoint_id: int, values: Sequence[float], now: float) -> None:
        """The array waits to be written, in place of one that waited; or it is rejected."""
        refusal = self.refusal(values)
        if refusal:
            self._tell(setpoint_id, "rejected", refusal)
            return
        older = self._waiting
        if older is not None:
            self._tell(
                older.setpoint_id, "superseded", f"array {setpoint_id} came before it was sent"
            )
        self._waiting = _Order(setpoint_id, self.counts(values), now)

    def refusal(self, values: Sequence[float]) -> str:
        """Why this array must not be sent; empty where it may (thesis section 4-2-1)."""
        if len(values) != len(self._slots):
            return f"{len(values)} values for {len(self._slots)} slots"
        for slot, value in zip(self._slots, values, strict=True):
            if not isfinite(value):
                return f"{slot.name} is no number"
            if abs(value) > slot.limit + _ROUNDING:
                return f"{slot.name} = {value:g} is beyond its limit of {slot.limit:g}"
        return ""

    def counts(self, values: Sequence[float]) -> Integers:
        """The array as the wire carries it."""
        pairs = zip(self._slots, values, strict=True)
        return tuple(round(value / slot.resolution) for slot, value in pairs)

    def reassert(self, now: float) -> None:
        """What was written last will be written again: the device may have forgotten it."""
        if self._flight is not None:
            self._flight.again, self._flight.began_s = True, now
        elif self._latest is not None and self._waiting is None:
            order = _Order(self._latest.setpoint_id, self._latest.counts, now)
            self._flight = _Flight(order, now, told=True, needed=True)

    # --- what is written --------------------------------------------------------------------

    @property
    def idle(self) -> bool:
        """Whether nothing waits and nothing is unanswered."""
        return self._waiting is None and self._flight is None

    @property
    def in_force(self) -> Integers | None:
        """What the device has, as far as can be told: the last confirmed, else what was tried."""
        if self.applied is not None:
            return self.applied
        return self._latest.counts if self._latest is not None else None

    @property
    def due_s(self) -> float:
        """When something is to be written, or given up."""
        flight, waiting = self._flight, self._waiting
        if flight is not None and not (flight.told and waiting is not None):
            return -inf if flight.again else flight.sent_s + self._patience_s
        if waiting is not None:
            return self._sent_s + self._gap_s
        return inf

    @property
    def _gap_s(self) -> float:
        """How long after the last writing a different array may be written."""
        return _HURRY * self._spacing_s if self._bad else self._spacing_s

    @property
    def _patience_s(self) -> float:
        """How long to wait for an echo before the next writing.

        Once one is late it is as good as lost. Where many are lost, waiting costs more than it
        saves: then copies follow each other as fast as the line and the ring of the receiver
        allow, still one at a time in there.
        """
        flight = self._flight
        if flight is not None and not flight.told and (self._bad or len(flight.numbers) > 1):
            return _HURRY * self._spacing_s
        return min(self._longest_s, self._mean_s + _SPREADS * self._spread_s + _MARGIN_S)

    @property
    def _bad(self) -> bool:
        """Whether so much is lost that no single writing can be relied upon.

        Echoes that do not come tell it, and so do the bytes of all that comes, long before the
        first array is written.
        """
        return max(self._loss, self._noise) > _BAD

    def expire(self, now: float, able: bool = True) -> None:
        """Whatever has been awaited for long enough is given up or will be written again.

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
                self._end(flight, f"array {waiting.setpoint_id} came before its echo")
            elif now >= flight.began_s + patience_s:
                self._lose(1.0)
                self._end(flight, f"no echo after {len(flight.numbers)} copies")
            else:
                flight.again = True
        if able:
            return
        flight = self._flight
        if flight is not None and now >= flight.began_s + budget_s:
            self._end(flight, "the link is down")
        if waiting is not None and now >= waiting.since_s + budget_s:
            self._waiting, self._latest = None, waiting  # to be repeated should the link return
            self._tell(waiting.setpoint_id, "unknown", "the link is down")

    def next_payload(self, now: float) -> bytes:
        """The payload to be written now, counted as written; empty when there is none."""
        flight = self._flight
        if flight is not None and flight.again and self._waiting is not None:
            # A repeat would come after something newer is wanted.
            self._end(flight, f"array {self._waiting.setpoint_id} came before its echo")
            flight = None
        if flight is None and self._waiting is not None and now >= self._sent_s + self._gap_s:
            flight = self._flight = _Flight(self._waiting, now)
            self._waiting = None
        if flight is None or not flight.again:
            return b""
        self._number = self._number % (self._ids - 1) + 1
        self._latest = flight.order
        self._recent[self._number] = flight.order.counts, now
        if len(self._recent) > min(_REMEMBERED, self._ids // 2):
            del self._recent[next(iter(self._recent))]
        self.repeats += bool(flight.numbers) or flight.told
        flight.numbers.append(self._number)
        flight.again = False
        flight.sent_s = self._sent_s = now
        self.written += 1
        return self._pack(self._number, flight.order.counts)

    # --- what is answered -------------------------------------------------------------------

    def echoed(self, number: int, counts: Integers, now: float) -> None:
        """The device has said what it applied."""
        flight = self._flight
        written, sent_s = self._recent.get(number, ((), now))
        if written != counts:
            self._correct(now)
            return
        if flight is None or number not in flight.numbers:
            return  # of an array that has been given up, or one more copy of one accepted
        self.applied = counts
        place = flight.numbers.index(number)
        self._learn(now - sent_s)
        self._lose(place / (place + 1))
        if not flight.told:
            flight.told, flight.began_s = True, now
            self._tell(flight.order.setpoint_id, "accepted", "")
        if number == flight.numbers[-1]:
            self._flight = None
        else:
            del flight.numbers[: place + 1]  # only later copies can still say something new

    def _learn(self, took_s: float) -> None:
        """An echo has taken so long."""
        self.round_trips.append(took_s)
        self._spread_s += _SPREAD_GAIN * (abs(took_s - self._mean_s) - self._spread_s)
        self._mean_s += _MEAN_GAIN * (took_s - self._mean_s)

    def _lose(self, share: float) -> None:
        """Of the last writings this share was not echoed."""
        self._losses += 1
        self._loss += max(_LOSS_GAIN, 1 / self._losses) * (share - self._loss)

    def listened(self, received: int, damaged: int) -> None:
        """So many bytes have come lately, so many have turned out to belong to no frame."""
        if received:
            part = min(1.0, received / _NOISE_BYTES)
            self._noise += part * (damaged / received - self._noise)

    def unreadable(self, now: float) -> None:
        """An echo has come that nobody can read."""
        self._correct(now)

    def take(self) -> list[SubmitResult | FaultReport]:
        """What has become of arrays since it was last asked."""
        results, self._results = self._results, []
        return results

    def _correct(self, now: float) -> None:
        """Something else may be in force than what was written last."""
        self.damaged += 1
        if self._flight is not None:
            self._flight.again = True
        else:
            self.reassert(now)

    def _end(self, flight: _Flight, reason: str) -> None:
        self._flight = None
        if not flight.told:
            self._tell(flight.order.setpoint_id, "unknown", reason)
        elif flight.needed and self._waiting is None:
            message = "the setpoints in force could not be confirmed again"
            self._results.append(FaultReport(NO_ECHO, message))

    def _tell(self, setpoint_id: int, status: SubmitStatus, reason: str) -> None:
        self._results.append(SubmitResult(setpoint_id, status, reason))
