"""The driver without its port: bytes and the time go in, events and bytes to write come out."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import inf, nan

from pirate_sm.core.events import BuiltInFault, Event, SensorFrame
from pirate_sm.robot.backends.serial.firmware_tables import said_tables
from pirate_sm.robot.backends.serial.link.arrays import SetpointLink
from pirate_sm.robot.backends.serial.link.conversation import (
    SILENT_AFTER_S,
    Conversation,
    TopicPayload,
    TopicRefused,
    TopicsKnown,
    sensors_off,
)
from pirate_sm.robot.backends.serial.link.health import Counts, Refreshing
from pirate_sm.robot.backends.serial.link.link_plan import (
    ECHO,
    SETPOINTS,
    STATE,
    LinkPlan,
    Throttle,
    to_counts,
    why_refused,
)
from pirate_sm.robot.backends.serial.link.recovery import (
    BRIEF,
    SAFE_WIRE_ID,
    Outage,
    Recovery,
    SafeArray,
    StopConfirmation,
    was_reset,
)
from pirate_sm.robot.rosserial.frames import OVERHEAD_BYTES, LogLine
from pirate_sm.robot.rosserial.message_types import Malformed
from pirate_sm.robot.rosserial.messages import Array, StateReading

# --- readings -------------------------------------------------------------------------------------


class Measurements:
    """Collects readings until they make the frame of a board.

    If a message carries one value, a board is reported when all its values have come. A lost value
    is replaced by the previous one when the next round begins.

    Args:
        channels: Number of channels of each board that reports.

    Attributes:
        strange: Readings of unknown boards or channels.
    """

    def __init__(self, channels: Mapping[int, int]) -> None:
        self._channels = dict(channels)
        self._values = {board: [nan] * count for board, count in channels.items()}
        self._fresh: dict[int, set[int]] = {board: set() for board in channels}
        self.strange = 0

    def take(self, reading: StateReading) -> SensorFrame | None:
        """Return the frame that this reading completes; None if it completes none."""
        board, channel, values = reading
        count = self._channels.get(board)
        if count is None or (len(values) < count if channel < 0 else channel >= count):
            self.strange += 1
            return None
        if channel < 0:
            return SensorFrame(board, values[:count])
        held, fresh = self._values[board], self._fresh[board]
        lapped = SensorFrame(board, tuple(held)) if channel in fresh else None
        if lapped is not None:
            fresh.clear()
        held[channel] = values[0]
        fresh.add(channel)
        if len(fresh) < count:
            return lapped
        fresh.clear()
        return SensorFrame(board, tuple(held))


# --- the exchange ---------------------------------------------------------------------------------


_GREETING_BYTES = OVERHEAD_BYTES * 2
"""The longest frame that the conversation itself writes, bytes."""

_INTRODUCTION_S = 0.06
"""A device that introduces its topics, some 270 bytes at 57,600 baud, reads nothing meanwhile."""

_EXPIRE_EVERY_S = 0.05
_WRITTEN_WITHIN_S = 0.1  # an array is in force so long after it was written, at most

_SILENT_SHARE = 0.4
"""Share of the time after which one board is silent; the link's silence is noticed first."""


class Exchange:
    """Turns setpoints into bytes and bytes into events, and holds the mission during silences.

    Args:
        plan: The robot's link plan.
        now: The time.
        epoch_s: Added to the time it gives seconds since 1970.
        baud: Baud rate of the line.

    Attributes:
        conversation: Introduces topics and notices silence.
        link: Sends arrays and follows their results.
        stopped: Whether the robot is known to be stopped.
        heard: Boards that have reported since the beginning.
        outage: The silence during which the mission is held; None while the link works.
        brief: Whether the last silence was too short to be an outage.
        throttle: Says when bytes may be written, by this exchange or another writer.
        given_up: Whether the last outage was given up, and nothing has come since.
        switch_stops_s: The length of a silence after which the firmware's switch has stopped the
            robot; arrays are repeated until the silence is noticed. Infinite without a switch.
        aside: Whether arrays wait until the engine has answered to an outage.
        newer: Whether an array has been submitted since the last outage began.
        refused: Why the controller cannot be that of this robot, one sentence each.
    """

    def __init__(self, plan: LinkPlan, now: float, epoch_s: float, baud: int) -> None:
        self._plan = plan
        self._epoch_s = epoch_s
        self.throttle = Throttle(baud)
        codec = plan.messages.setpoints
        self._setpoint_bytes = len(codec.pack(0, [0] * len(plan.slots))) + OVERHEAD_BYTES
        self._safe = SafeArray(codec, plan.safe_zero, len(plan.slots))
        self.link = SetpointLink(
            plan.slots,
            codec.pack,
            refreshing=Refreshing(plan.serial.refresh_every or inf, plan.serial.stop_after or inf),
            echo_within_s=plan.serial.echo_within,
            spacing_s=self.throttle.spacing_s(self._setpoint_bytes),
            ids=codec.ids,
        )
        self.link.hold = self._safe.kept
        self._silent_s = min(SILENT_AFTER_S, _SILENT_SHARE * plan.silent_after_s)
        stop_after_s = plan.serial.stop_after or inf
        self.switch_stops_s = self._silent_s + stop_after_s + _WRITTEN_WITHIN_S
        self.stopped = StopConfirmation(plan.safe_zero)
        self._measurements = Measurements(plan.channels)
        advice = sensors_off(plan.serial.advice.no_sensors)
        self._recovery = Recovery(BRIEF * plan.silent_after_s, plan.away_s, advice)
        self._left_out_s = 0.0
        self._events: list[Event] = []
        self._safe_frame = b""
        self._unreadable = 0
        self._flowing = False
        self._watching = False
        self.outage: Outage | None = None
        self.given_up = self.aside = self.newer = self.brief = False
        self.heard: set[int] = set()
        self.refused: list[str] = []
        self.conversation = self._begin(now)

    def _begin(self, now: float) -> Conversation:
        boot_s = self._plan.serial.boot
        return Conversation(self._plan.wanted, now, self._epoch_s, boot_s, self._silent_s)

    # --- the link itself --------------------------------------------------------------------

    def watch(self) -> None:
        """From now on hold the mission in every silence, until its cause is clear."""
        self._watching = True

    def lost(self, reason: str, now: float) -> None:
        """Handle that the port has gone."""
        outage = self._hold(now)
        if outage is not None:
            outage.relapse()
            outage.gone = outage.gone or reason

    def connected(self, now: float) -> None:
        """Handle that the port is open again, and ask for topics as at the beginning."""
        self.conversation = self._begin(now)
        if self.outage is not None:
            self.outage.sign_s = now

    def resume(self, now: float) -> None:
        """Send the newest array, because the engine has answered to an outage."""
        if self.aside and self.outage is None:
            self.aside = False
            self.link.reassert(now)

    # --- in ---------------------------------------------------------------------------------

    def submit(self, setpoint_id: int, values: tuple[float, ...], now: float) -> None:
        """Submit an array."""
        self.newer = True
        self.link.submit(setpoint_id, values, now)
        self._events += self.link.take()

    def hold(self, values: tuple[float, ...], seeking: Collection[int] = ()) -> None:
        """Set the safe array, which is sent when nobody can send another one.

        Args:
            values: The safe array; ignored if it must not be sent.
            seeking: Slots that a position loop drives. The firmware's switch stops them, if the
                message has a field for them.
        """
        if not why_refused(self._plan.slots, values):
            self._safe.held = to_counts(self._plan.slots, values)
        loose = seeking if self._plan.messages.setpoints.holds else ()
        self.link.hold = self._safe.kept & ~sum(1 << at for at in loose)

    def receive(self, data: bytes, now: float) -> None:
        """Handle bytes from the port."""
        if self.outage is None and not self.aside:
            self._notice_silence(now)  # this program may have stood still while it waited for them
        dropped = self.conversation.dropped
        for heard in self.conversation.receive(data, now):
            if isinstance(heard, TopicsKnown):
                self._know(heard, now)
            self._notice_return(now)
            if isinstance(heard, TopicPayload):
                self._take(heard, now)
            elif isinstance(heard, TopicRefused):
                self._refuse(heard.reason)
            elif isinstance(heard, LogLine):
                self._compare_tables()
        self.link.quality.listened(len(data), self.conversation.dropped - dropped)
        self._events += self.link.take()

    def take(self) -> list[Event]:
        """Return the events since the last call, oldest first."""
        events, self._events = self._events, []
        return events

    def take_left_out_s(self) -> float:
        """Return, once, how long this program stood still without hearing the device, s.

        Mission time leaves this time out. Otherwise boards would seem silent, although their
        reports wait to be read, and reading them takes a busy computer a while.
        """
        left_out_s, self._left_out_s = self._left_out_s, 0.0
        return left_out_s

    # --- out --------------------------------------------------------------------------------

    def due_s(self, now: float) -> float:
        """Return when there is something to do, if nothing comes before."""
        due = self.conversation.due_s
        if due <= now:
            due = self.throttle.free_s(_GREETING_BYTES, now)
        if not self.conversation.known:
            due = min(due, now + _EXPIRE_EVERY_S)  # meanwhile arrays can only be given up
        if self.outage is not None:
            safe_due = self._recovery.due_s(self.outage)
            if safe_due <= now:
                safe_due = self.throttle.free_s(self._setpoint_bytes, now)
            return min(due, safe_due)
        if self.aside or not self.conversation.known:
            return due
        link_due = self.link.due_s
        if link_due <= now:
            link_due = self.throttle.free_s(self._setpoint_bytes, now)
        return min(due, link_due)

    def write(self, now: float, able: bool = True) -> bytes:
        """Return the frame to write now, in one call; empty if there is none.

        Args:
            now: The time.
            able: Whether there is a port; without one only time passes.
        """
        data, busy_s = b"", 0.0
        if able and self.throttle.free_s(_GREETING_BYTES, now) <= now:
            data = self.conversation.write(now)
            if data and self.conversation.asking:
                busy_s = _INTRODUCTION_S
            self._notice_silence(now)
        if self.outage is not None:
            self._judge(self.outage, now)
        if self.outage is None and not self.aside:
            self.link.expire(now, able and self.conversation.known)
            self._events += self.link.take()
        fits = able and self.throttle.free_s(self._setpoint_bytes, now) <= now
        if not data and fits and self.conversation.known:
            data = self._setpoints(now)
        if data:
            self.throttle.wrote(len(data), now, busy_s)
        return data

    def safe_frame(self) -> bytes:
        """Return the frame of the safe array: zero where the safe state stops, the rest held.

        Empty before anything has been sent, because the robot stands as it was found.
        """
        counts = self.link.in_force
        if counts is None:
            return b""
        frame = self.conversation.frame(SETPOINTS, self._safe.payload(counts))
        if frame or self.conversation.known:
            self._safe_frame = frame
        return self._safe_frame  # until topics are known again, their old numbers

    @property
    def at_rest(self) -> bool:
        """Whether the robot needs no stop: its last array is the safe one, and it has echoed that.

        This is also so before anything has been sent, because the robot stands as it was found.
        """
        if self.link.in_force is None:
            return True
        self._safe.payload(self.link.in_force)
        return self.outage is None and self.link.confirmed == self._safe.counts

    def guarded_frame(self) -> bytes:
        """Return the frame with which a guardian stops the robot; empty if it needs no stop."""
        return b"" if self.at_rest else self.safe_frame()

    @property
    def settled(self) -> bool:
        """Whether nothing is under way, so that the right array is in force, as far as known.

        After an outage that is the safe array, until a newer one is submitted.
        """
        if self.outage is not None:
            return not self.safe_frame()
        return (self.aside and not self.newer) or self.link.idle

    @property
    def counts(self) -> Counts:
        """Counts of what has happened on the link."""
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
        """Return the present outage, beginning one if needed; None if outages are not watched."""
        outage = self.outage
        if outage is not None:
            if outage.back:
                outage.relapse()
        elif self._watching and not self.given_up:
            heard_s = self.conversation.heard_s
            # Had this program stood still, no more mission time must pass than otherwise.
            since_s = min(now, heard_s + self._silent_s)
            outage = self.outage = Outage(heard_s, since_s, sign_s=heard_s)
            self.aside = self.newer = self.brief = False
        return outage

    def _notice_silence(self, now: float) -> None:
        """Begin an outage if nothing has come for too long; what has come now ends it."""
        if self.conversation.asking or now >= self.conversation.heard_s + self._silent_s:
            self._hold(now)

    def _notice_return(self, now: float) -> None:
        """Handle that the controller speaks again; whether it has recovered is decided later."""
        outage = self.outage
        if self.conversation.asking:
            return
        if outage is None:
            self.given_up = False
        elif not outage.back:
            longer = outage.answered_s < inf  # it was too long before a relapse
            outage.return_(now, self.heard, bool(self.safe_frame()))
            self.brief = not longer and self._recovery.is_brief(outage, self.conversation.silence_s)
            if self.brief:
                self.outage = None
                awake_s = max(0.0, self.conversation.silence_s - self._silent_s)
                self._left_out_s += max(0.0, now - outage.since_s - awake_s)

    @property
    def gives_up_s(self) -> float:
        """When the present silence will be given up; infinite while there is none."""
        return inf if self.outage is None else self._recovery.gives_up_s(self.outage)

    def _judge(self, outage: Outage, now: float) -> None:
        """Report an outage as soon as its cause is clear."""
        outage.sign_s = max(outage.sign_s, self.conversation.heard_s)
        fault = self._recovery.verdict(outage, now, bool(self.safe_frame()))
        if fault is None:
            return
        recovered = outage.back and not outage.dumb
        self.outage, self.given_up, self.aside = None, not recovered, recovered
        self._events += [fault, *outage.frames.values()]

    def _setpoints(self, now: float) -> bytes:
        """Return the frame with the array to write now; empty if there is none."""
        outage = self.outage
        if outage is not None:
            if not self._recovery.wants_safe(outage, now):
                return b""
            outage.wrote_s = now
            self.stopped.wrote(SAFE_WIRE_ID, self._safe.counts)
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

    def _take(self, message: TopicPayload, now: float) -> None:
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
        if self.refused:
            return  # another robot's controller confirms nothing of this one
        self.stopped.echoed(array.number, array.counts)
        if array.number != SAFE_WIRE_ID or array.counts != self._safe.counts:
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

    def _know(self, known: TopicsKnown, now: float) -> None:
        if self.outage is not None:
            self.outage.anew = True
            if not self.outage.gone:  # else its silence began before the port was reopened
                self.outage.silence_s = known.silence_s
        elif known.again or self.link.in_force is not None:
            # The device may have forgotten its setpoints.
            self.link.reassert(now)
        if known.again and self._flowing and not self._watching:
            self._flowing = False
            away_s = known.silence_s
            self._events.append(BuiltInFault.FIRMWARE_RESET.report(was_reset(away_s), away_s))

    def _compare_tables(self) -> None:
        """Refuse a firmware that only ever names tables of another robot; most name none."""
        lines, ours = self.conversation.recent, self._plan.tables
        theirs = [tables for line in lines if (tables := said_tables(line.text))]
        if theirs and ours and ours not in theirs:
            self._refuse(
                f"the firmware is that of {theirs[-1]}, the profile is that of {ours}: write the "
                "tables by `pirate firmware`, then build and flash it, or use the files that it "
                "was flashed with. Flashing releases what the robot holds"
            )

    def _refuse(self, reason: str) -> None:
        if reason in self.refused:
            return
        self.refused.append(reason)
        if self.heard:
            self.outage, self.given_up = None, True
            self._events.append(BuiltInFault.LINK_MISMATCH.report(reason))
