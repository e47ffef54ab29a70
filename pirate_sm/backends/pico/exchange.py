"""The driver without its port: bytes in with the time, events and bytes to be written out."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.backends.pico.conversation import Conversation, Known, Message, Refused
from pirate_sm.backends.pico.framing import OVERHEAD_BYTES
from pirate_sm.backends.pico.link import SetpointLink
from pirate_sm.backends.pico.measurements import Measurements
from pirate_sm.backends.pico.messages import Malformed
from pirate_sm.backends.pico.plan import ECHO, SETPOINTS, STATE, Plan
from pirate_sm.backends.pico.supervision import Supervision
from pirate_sm.backends.pico.throttle import Throttle
from pirate_sm.model.events import Event, FaultReport

RESET = "firmware.reset"
MISMATCH = "link.mismatch"

_GREETING_BYTES = OVERHEAD_BYTES * 2
"""What the conversation itself writes is not longer."""

SAFE_WIRE_ID = 0

_EXPIRE_EVERY_S = 0.05


class Counts(NamedTuple):
    """What the link has seen, for people.

    Attributes:
        dropped: Bytes that belonged to no frame.
        unreadable: Payloads that were not what their type says.
        strange: Frames and readings of nothing that is known.
        damaged: Echoes of something else than was written.
        repeats: Frames written again.
        hidden: Spikes of sensors that were not passed on.
    """

    frames: int
    dropped: int
    unreadable: int
    strange: int
    written: int
    damaged: int
    repeats: int
    hidden: int


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
        heard: Boards that have reported since the beginning.
        refused: Why a topic cannot be used, one sentence each.
    """

    def __init__(self, plan: Plan, now: float, epoch_s: float, baud: int) -> None:
        self._plan = plan
        self._epoch_s = epoch_s
        self._throttle = Throttle(baud)
        payload = plan.messages.setpoints.pack(0, [0] * len(plan.slots))
        self._setpoint_bytes = len(payload) + OVERHEAD_BYTES
        codec = plan.messages.setpoints
        self.link = SetpointLink(
            plan.slots,
            codec.pack,
            echo_within_s=plan.serial.echo_within,
            spacing_s=self._throttle.spacing_s(self._setpoint_bytes),
            ids=codec.ids,
        )
        self._measurements = Measurements(plan.channels)
        self._supervision = Supervision(plan.watched, plan.wheels)
        self._events: list[Event] = []
        self._held: tuple[int, ...] | None = None
        self._safe_counts: tuple[int, ...] | None = None
        self._safe_payload = b""
        self._unreadable = 0
        self._flowing = False
        self.heard: set[int] = set()
        self.refused: list[str] = []
        self.conversation = self._begin(now)

    def connected(self, now: float) -> None:
        """The port has been opened again: topics are asked for, then the last array repeated."""
        self.conversation = self._begin(now)
        self._flowing = False

    def _begin(self, now: float) -> Conversation:
        return Conversation(self._plan.wanted, now, self._epoch_s, self._plan.serial.boot)

    # --- in ---------------------------------------------------------------------------------

    def submit(self, setpoint_id: int, values: tuple[float, ...], now: float) -> None:
        """The array is on its way."""
        self.link.submit(setpoint_id, values, now)
        self._events += self.link.take()

    def hold(self, values: tuple[float, ...]) -> None:
        """This is the safe array, if it may be sent at all."""
        if not self.link.refusal(values):
            self._held = self.link.counts(values)

    def receive(self, data: bytes, now: float) -> None:
        """The bytes have had their consequences."""
        for heard in self.conversation.receive(data, now):
            if isinstance(heard, Message):
                self._take(heard, now)
            elif isinstance(heard, Known):
                self._know(heard, now)
            else:
                self._refuse(heard)
        self._events += self.link.take()

    def take(self) -> list[Event]:
        """What has happened since it was last asked, oldest first."""
        events, self._events = self._events, []
        return events

    # --- out --------------------------------------------------------------------------------

    def due_s(self, now: float) -> float:
        """When there will be something to do, if nothing comes before."""
        due = self.conversation.due_s
        if due <= now:
            due = self._throttle.free_s(_GREETING_BYTES, now)
        if not self.conversation.known:
            return min(due, now + _EXPIRE_EVERY_S)  # arrays can only be given up meanwhile
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
        self.link.expire(now, able and self.conversation.known)
        self._events += self.link.take()
        if not able:
            return b""
        data = b""
        if self._throttle.free_s(_GREETING_BYTES, now) <= now:
            data = self.conversation.write(now)
        fits = self._throttle.free_s(self._setpoint_bytes, now) <= now
        if not data and fits and self.conversation.known:
            data = self._setpoints(now)
        if data:
            self._throttle.wrote(len(data), now)
        return data

    def safe_frame(self) -> bytes:
        """The frame that stops what the safe state stops and holds what it holds; or nothing.

        There is none before anything has been sent: the robot stands as it was found.
        """
        counts = self.link.in_force
        if counts is None:
            return b""
        if self._held is not None:
            counts = self._held
        if counts is not self._safe_counts:  # asked for at every turn
            zero = set(self._plan.safe_zero)
            safe = [0 if slot in zero else count for slot, count in enumerate(counts)]
            self._safe_counts = counts
            self._safe_payload = self._plan.messages.setpoints.pack(SAFE_WIRE_ID, safe)
        return self.conversation.frame(SETPOINTS, self._safe_payload)

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
            hidden=self._supervision.hidden,
        )

    # --- inside -----------------------------------------------------------------------------

    def _setpoints(self, now: float) -> bytes:
        payload = self.link.next_payload(now)
        self._events += self.link.take()
        if not payload:
            return b""
        _, counts = self._plan.messages.setpoints.unpack(payload)
        pairs = zip(self._plan.slots, counts, strict=True)
        self._supervision.actuated(tuple(slot.resolution * count for slot, count in pairs), now)
        return self.conversation.frame(SETPOINTS, payload)

    def _take(self, message: Message, now: float) -> None:
        try:
            if message.which == STATE:
                self._measure(message.payload, now)
            elif message.which == ECHO:
                number, counts = self._plan.messages.echo.unpack(message.payload)
                self.link.echoed(number, counts, now)
        except Malformed:
            self._unreadable += 1
            if message.which == ECHO:
                self.link.unreadable(now)

    def _measure(self, payload: bytes, now: float) -> None:
        frame = self._measurements.take(self._plan.messages.state.unpack(payload))
        if frame is None:
            return
        self._flowing = True
        self.heard.add(frame.board)
        frame, faults = self._supervision.look(frame, now)
        self._events += faults
        self._events.append(frame)

    def _know(self, known: Known, now: float) -> None:
        if known.again or self.link.in_force is not None:
            # It may have forgotten what it was told, and counters may begin at zero.
            self._supervision.forget()
            self.link.reassert(now)
        if known.again and self._flowing:
            self._flowing = False
            message = (
                f"the robot's controller said nothing for {known.silence_s:.1f} s and had to be "
                "asked anew: it has been reset, or hung"
            )
            self._events.append(FaultReport(RESET, message))

    def _refuse(self, refused: Refused) -> None:
        self.refused.append(refused.reason)
        if self.heard:
            self._events.append(FaultReport(MISMATCH, refused.reason))
