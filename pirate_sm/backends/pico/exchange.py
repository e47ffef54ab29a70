"""The driver without its port: bytes in with the time, events and bytes to be written out."""

from __future__ import annotations

from collections.abc import Collection
from math import inf

from pirate_sm.backends.pico.conversation import (
    SILENT_AFTER_S,
    Conversation,
    Known,
    Message,
    Refused,
)
from pirate_sm.backends.pico.counts import Counts
from pirate_sm.backends.pico.diagnosis import sensors_off
from pirate_sm.backends.pico.framing import OVERHEAD_BYTES
from pirate_sm.backends.pico.line_quality import Refreshing
from pirate_sm.backends.pico.link import SetpointLink
from pirate_sm.backends.pico.measurements import Measurements
from pirate_sm.backends.pico.messages import Array, Malformed
from pirate_sm.backends.pico.plan import ECHO, SETPOINTS, STATE, Plan
from pirate_sm.backends.pico.recovery import BRIEF, Outage, Recovery, was_reset
from pirate_sm.backends.pico.stopped import Stopped
from pirate_sm.backends.pico.throttle import Throttle
from pirate_sm.model.events import Event
from pirate_sm.model.fault_codes import BuiltInFault

_GREETING_BYTES = OVERHEAD_BYTES * 2
"""What the conversation itself writes is not longer."""

SAFE_WIRE_ID = 0

_INTRODUCTION_S = 0.06
"""A device that introduces its topics, some 270 bytes at 57,600 baud, reads nothing meanwhile."""

_EXPIRE_EVERY_S = 0.05

_SILENT_SHARE = 0.4
"""Of the time after which a single board is silent: none may be so before all of them are."""


class Exchange:
    """Everything between the engine and the bytes on the wire.

    Args:
        plan: The robot on its wire.
        now: The time.
        epoch_s: Added to the time it gives seconds since 1970.
        baud: Of the line.

    Attributes:
        conversation: What has been said about topics.
        link: What has become of arrays.
        stopped: Whether the robot is known to be stopped.
        heard: Boards that have reported since the beginning.
        outage: The silence during which the mission is held; None while all is well.
        brief: Whether the last outage was none, only a short silence.
        aside: Whether arrays wait until whoever was told of an outage has had a say.
        newer: Whether an array has been submitted since the last outage began.
        refused: Why a topic cannot be used, one sentence each.
    """

    def __init__(self, plan: Plan, now: float, epoch_s: float, baud: int) -> None:
        self._plan = plan
        self._epoch_s = epoch_s
        self._throttle = Throttle(baud)
        payload = plan.messages.setpoints.pack(0, [0] * len(plan.slots))
        self._setpoint_bytes = len(payload) + OVERHEAD_BYTES
        codec = plan.messages.setpoints
        self._kept = sum(1 << at for at in range(len(plan.slots)) if at not in plan.safe_zero)
        self.link = SetpointLink(
            plan.slots,
            codec.pack,
            refreshing=Refreshing(plan.serial.refresh_every or inf, plan.serial.stop_after or inf),
            echo_within_s=plan.serial.echo_within,
            spacing_s=self._throttle.spacing_s(self._setpoint_bytes),
            ids=codec.ids,
        )
        self.link.hold = self._kept
        self._silent_s = min(SILENT_AFTER_S, _SILENT_SHARE * plan.silent_after_s)
        self.stopped = Stopped(plan.safe_zero)
        self._measurements = Measurements(plan.channels)
        advice = sensors_off(plan.serial.advice.no_sensors)
        self._recovery = Recovery(BRIEF * plan.silent_after_s, plan.away_s, advice)
        self._left_out_s = 0.0
        self._events: list[Event] = []
        self._held: tuple[int, ...] | None = None
        self._safe_from: tuple[int, ...] | None = None
        self._safe_counts: tuple[int, ...] = ()
        self._safe_payload = b""
        self._safe_frame = b""
        self._unreadable = 0
        self._flowing = False
        self._watching = False
        self._given_up = False
        self.outage: Outage | None = None
        self.aside = False
        self.brief = False
        self.newer = False
        self.heard: set[int] = set()
        self.refused: list[str] = []
        self.conversation = self._begin(now)

    def _begin(self, now: float) -> Conversation:
        boot_s = self._plan.serial.boot
        return Conversation(self._plan.wanted, now, self._epoch_s, boot_s, self._silent_s)

    # --- the link itself --------------------------------------------------------------------

    def watch(self) -> None:
        """From now on a silence holds the mission until it is clear what has happened."""
        self._watching = True

    def lost(self, reason: str, now: float) -> None:
        """The port has gone."""
        outage = self._hold(now)
        if outage is not None:
            outage.relapse()
            outage.gone = outage.gone or reason

    def connected(self, now: float) -> None:
        """The port has been opened again: topics are asked for as at the beginning."""
        self.conversation = self._begin(now)
        if self.outage is not None:
            self.outage.sign_s = now

    def resume(self, now: float) -> None:
        """Whoever was told of an outage has had a say: the newest array is to be in force."""
        if self.aside and self.outage is None:
            self.aside = False
            self.link.reassert(now)

    # --- in ---------------------------------------------------------------------------------

    def submit(self, setpoint_id: int, values: tuple[float, ...], now: float) -> None:
        """The array is on its way."""
        self.newer = True
        self.link.submit(setpoint_id, values, now)
        self._events += self.link.take()

    def hold(self, values: tuple[float, ...], seeking: Collection[int] = ()) -> None:
        """Take note of what is to be held should nobody be able to send anything more.

        Args:
            values: The safe array; ignored where it must not be sent.
            seeking: Slots that a position loop drives. The firmware's switch stops them, if the
                message can tell it which they are.
        """
        if not self.link.refusal(values):
            self._held = self.link.counts(values)
        loose = seeking if self._plan.messages.setpoints.holds else ()
        self.link.hold = self._kept & ~sum(1 << at for at in loose)

    def receive(self, data: bytes, now: float) -> None:
        """The bytes have had their consequences."""
        dropped = self.conversation.dropped
        for heard in self.conversation.receive(data, now):
            if isinstance(heard, Known):
                self._know(heard, now)
            self._notice_return(now)
            if isinstance(heard, Message):
                self._take(heard, now)
            elif isinstance(heard, Refused):
                self._refuse(heard)
        self.link.quality.listened(len(data), self.conversation.dropped - dropped)
        self._events += self.link.take()

    def take(self) -> list[Event]:
        """What has happened since it was last asked, oldest first."""
        events, self._events = self._events, []
        return events

    def take_left_out_s(self) -> float:
        """Return how much longer this program stood still than a short silence lasts, once, s.

        In the mission that time does not pass: every board would seem to be silent, though their
        reports wait to be read.
        """
        left_out_s, self._left_out_s = self._left_out_s, 0.0
        return left_out_s

    # --- out --------------------------------------------------------------------------------

    def due_s(self, now: float) -> float:
        """When there will be something to do, if nothing comes before."""
        due = self.conversation.due_s
        if due <= now:
            due = self._throttle.free_s(_GREETING_BYTES, now)
        if not self.conversation.known:
            due = min(due, now + _EXPIRE_EVERY_S)  # arrays can only be given up meanwhile
        if self.outage is not None:
            safe_due = self._recovery.due_s(self.outage)
            if safe_due <= now:
                safe_due = self._throttle.free_s(self._setpoint_bytes, now)
            return min(due, safe_due)
        if self.aside or not self.conversation.known:
            return due
        link_due = self.link.due_s
        if link_due <= now:
            link_due = self._throttle.free_s(self._setpoint_bytes, now)
        return min(due, link_due)

    def write(self, now: float, able: bool = True) -> bytes:
        """The next frame to be written now, to be written in one call; empty when there is none.

        Args:
            now: The time.
            able: Whether there is a port; without one nothing is returned and time passes.
        """
        data, busy_s = b"", 0.0
        if able and self._throttle.free_s(_GREETING_BYTES, now) <= now:
            data = self.conversation.write(now)
            if self.conversation.asking:
                busy_s = _INTRODUCTION_S if data else 0.0
            if self.conversation.asking or now >= self.conversation.heard_s + self._silent_s:
                self._hold(now)
        if self.outage is not None:
            self._judge(self.outage, now)
        if self.outage is None and not self.aside:
            self.link.expire(now, able and self.conversation.known)
            self._events += self.link.take()
        fits = able and self._throttle.free_s(self._setpoint_bytes, now) <= now
        if not data and fits and self.conversation.known:
            data = self._setpoints(now)
        if data:
            self._throttle.wrote(len(data), now, busy_s)
        return data

    def room_s(self, size: int, now: float) -> float:
        """When this many bytes may be written."""
        return self._throttle.free_s(size, now)

    def wrote(self, size: int, now: float) -> None:
        """So many bytes have been written past the exchange."""
        self._throttle.wrote(size, now)

    def safe_frame(self) -> bytes:
        """The frame that stops what the safe state stops and holds what it holds; or nothing.

        There is none before anything has been sent: the robot stands as it was found.
        """
        counts = self.link.in_force
        if counts is None:
            return b""
        if self._held is not None:
            counts = self._held
        if counts is not self._safe_from:  # asked for at every turn
            zero = set(self._plan.safe_zero)
            safe = tuple(0 if slot in zero else count for slot, count in enumerate(counts))
            self._safe_from, self._safe_counts = counts, safe
            self._safe_payload = self._plan.messages.setpoints.pack(SAFE_WIRE_ID, safe, self._kept)
        frame = self.conversation.frame(SETPOINTS, self._safe_payload)
        if frame or self.conversation.known:
            self._safe_frame = frame
        return self._safe_frame  # while topics are not known again, what they were

    @property
    def settled(self) -> bool:
        """Whether nothing is under way: what is to be in force is, as far as can be told.

        After an outage that is the safe array, until something newer is wanted.
        """
        if self.outage is not None:
            return not self.safe_frame()
        return (self.aside and not self.newer) or self.link.idle

    @property
    def counts(self) -> Counts:
        """What the link has seen."""
        conversation, link = self.conversation, self.link
        return Counts(
            frames=conversation.frames,
            dropped=conversation.dropped,
            unreadable=self._unreadable,
            strange=conversation.strange + self._measurements.strange,
            written=link.written,
            damaged=link.damaged,
            repeats=link.repeats,
            refreshes=link.refreshes,
            trips=link.trips,
        )

    # --- inside -----------------------------------------------------------------------------

    def _hold(self, now: float) -> Outage | None:
        """The outage that there is, or that begins now; None where none is looked for."""
        outage = self.outage
        if outage is not None:
            if outage.back:
                outage.relapse()
        elif self._watching and not self._given_up:
            heard_s = self.conversation.heard_s
            # This program may have stood still: no more mission time passes than if it had not.
            since_s = min(now, heard_s + self._silent_s)
            outage = self.outage = Outage(heard_s, since_s, sign_s=heard_s)
            self.aside = self.newer = False
        return outage

    def _notice_return(self, now: float) -> None:
        """A controller that speaks again is looked at before anything is believed."""
        outage = self.outage
        if self.conversation.asking:
            return
        if outage is None:
            self._given_up = False
        elif not outage.back:
            outage.return_(now, self.heard, bool(self.safe_frame()))
            self.brief = self._recovery.is_brief(outage, self.conversation.silence_s)
            if self.brief:
                self.outage = None
                most_s = self._recovery.brief_s - self._silent_s
                self._left_out_s += max(0.0, now - outage.since_s - most_s)

    @property
    def gives_up_s(self) -> float:
        """When the silence that there is will be given up; infinite while there is none."""
        return inf if self.outage is None else self._recovery.gives_up_s(self.outage)

    def _judge(self, outage: Outage, now: float) -> None:
        """An outage of which it is clear what it was has been told."""
        outage.sign_s = max(outage.sign_s, self.conversation.heard_s)
        fault = self._recovery.verdict(outage, now, bool(self.safe_frame()))
        if fault is None:
            return
        recovered = outage.back and not outage.dumb
        self.outage, self._given_up, self.aside = None, not recovered, recovered
        self._events += [fault, *outage.frames.values()]

    def _setpoints(self, now: float) -> bytes:
        """The frame with the array that is to be written now; empty when there is none."""
        outage = self.outage
        if outage is not None:
            if not self._recovery.wants_safe(outage, now):
                return b""
            outage.wrote_s = now
            self.stopped.wrote(SAFE_WIRE_ID, self._safe_counts)
            return self.safe_frame()
        if self.aside:
            return b""
        payload = self.link.next_payload(now)
        self._events += self.link.take()
        if not payload:
            return b""
        array = self._plan.messages.setpoints.unpack(payload)
        self.stopped.wrote(array.number, array.counts)
        return self.conversation.frame(SETPOINTS, payload)

    def _take(self, message: Message, now: float) -> None:
        try:
            if message.which == STATE:
                self._measure(message.payload)
            elif message.which == ECHO:
                self._echo(self._plan.messages.echo.unpack(message.payload), now)
        except Malformed:
            self._unreadable += 1
            if message.which == ECHO:
                self.link.unreadable(now)

    def _echo(self, array: Array, now: float) -> None:
        self.stopped.echoed(array.number, array.counts)
        if array.number != SAFE_WIRE_ID or array.counts != self._safe_counts:
            self.link.echoed(array.number, array.counts, now, array.hold)
        elif self.outage is not None:
            self.outage.confirm(now)

    def _measure(self, payload: bytes) -> None:
        frame = self._measurements.take(self._plan.messages.state.unpack(payload))
        if frame is None:
            return
        self._flowing = True
        self.heard.add(frame.board)
        if self.outage is not None:
            self.outage.report(frame)
            return
        self._events.append(frame)

    def _know(self, known: Known, now: float) -> None:
        if self.outage is not None:
            self.outage.anew = True
            if not self.outage.gone:  # else it was silent since before the port was opened again
                self.outage.silence_s = known.silence_s
        elif known.again or self.link.in_force is not None:
            # It may have forgotten what it was told.
            self.link.reassert(now)
        if known.again and self._flowing and not self._watching:
            self._flowing = False
            self._events.append(BuiltInFault.FIRMWARE_RESET.report(was_reset(known.silence_s)))

    def _refuse(self, refused: Refused) -> None:
        self.refused.append(refused.reason)
        if self.heard:
            self.outage, self._given_up = None, True
            self._events.append(BuiltInFault.LINK_MISMATCH.report(refused.reason))
