"""The guardian's decisions: when the runner falls silent, the guardian stops the robot itself.

Pure: notes of the runner, bytes of the port and the time go in, and actions come out: write to the
port, send a note to the runner, reopen, end. The process around it is
:mod:`pirate_sm.robot.backends.serial.guardian.process`.
"""

from __future__ import annotations

import json
import struct
from enum import IntEnum
from math import inf
from typing import NamedTuple, Self, TypeAlias

from pirate_sm.robot.backends.serial.link.conversation import Conversation, SilenceTimer, Wanted
from pirate_sm.robot.rosserial.frames import (
    FIRST_OF_THE_DEVICE,
    TX_STOP,
    Decoder,
    SerialFrame,
    encode,
)

# --- notes ----------------------------------------------------------------------------------------


_HEADER = struct.Struct("<BI")
_LONGEST = 1 << 20


class NoteKind(IntEnum):
    """Kinds of notes. The runner sends the first group, the guardian the second."""

    WRITE = 1
    BEAT = 2
    HEED = 4
    LEAVE = 5
    STOP = 6

    DATA = 16
    OPENED = 17
    REFUSED = 18
    LOST = 19
    OVERRULED = 20
    HEARD = 21
    STOPPED = 22


class Note(NamedTuple):
    """One message between runner and guardian.

    Attributes:
        kind: ``WRITE``: write this frame. ``BEAT``: the runner lives, and this frame is the safe
            one. ``HEED``: the runner knows that it was overruled. ``LEAVE``: the robot is stopped
            and needs no guardian any more. ``STOP``: an earlier run has left the robot without a
            confirmed stop; this is the safe payload. ``DATA``: bytes that the port has received.
            ``OPENED``, ``REFUSED``, ``LOST``: the port was opened, could not be opened, has gone.
            ``OVERRULED``: the guardian has acted. ``HEARD``: it has received a beat.
            ``STOPPED``: the robot has confirmed the safe array.
        body: Bytes of the port, the safe frame, or text for people.
    """

    kind: NoteKind
    body: bytes = b""

    def to_bytes(self) -> bytes:
        """Return the note as bytes for the pipe."""
        return _HEADER.pack(self.kind, len(self.body)) + self.body


class NoteReader:
    """Splits the bytes from the pipe into notes."""

    def __init__(self) -> None:
        self._pending = b""

    def feed(self, data: bytes) -> list[Note]:
        """Return the notes that these bytes complete.

        Raises:
            ValueError: The bytes are not a note.
        """
        self._pending += data
        notes: list[Note] = []
        while len(self._pending) >= _HEADER.size:
            kind, length = _HEADER.unpack_from(self._pending)
            if length > _LONGEST:
                raise ValueError("not a note")
            end = _HEADER.size + length
            if len(self._pending) < end:
                break
            notes.append(Note(NoteKind(kind), self._pending[_HEADER.size : end]))
            self._pending = self._pending[end:]
        return notes


class Instructions(NamedTuple):
    """The arguments of a guardian at its start.

    Attributes:
        silence_s: The guardian stops the robot when it has not heard the runner for this long.
        wanted: The robot's topics, in the order of the plan. The guardian asks for them again after
            the port was reopened, because their numbers may differ.
        boot_s: How long the controller's boot loader may run after the port was opened.
        stay_s: How long the guardian tries, without a runner, to have the stop confirmed.
    """

    silence_s: float
    wanted: tuple[Wanted, ...] = ()
    boot_s: float = 0.0
    stay_s: float = 600.0

    @property
    def array(self) -> int:
        """Index of the topic that takes arrays of setpoints; -1 if there is none."""
        return next((n for n, each in enumerate(self.wanted) if each.direction == "takes"), -1)

    @property
    def array_md5(self) -> str:
        """The md5 of the definition of an array of setpoints."""
        return self.wanted[self.array].md5 if self.wanted else ""

    def to_json(self) -> str:
        """Return the instructions as text, for a command line."""
        # The definitions serve people only, and are too long for an argument.
        wanted = [each._replace(text="") for each in self.wanted]
        return json.dumps(self._replace(wanted=tuple(wanted)))

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Return the instructions that :meth:`to_json` has written."""
        silence_s, wanted, boot_s, stay_s = json.loads(text)
        return cls(silence_s, tuple(Wanted(*each) for each in wanted), boot_s, stay_s)


# --- actions --------------------------------------------------------------------------------------


class ToPort(NamedTuple):
    """Write these bytes to the port in one call."""

    data: bytes


class ToRunner(NamedTuple):
    """Send this note to the runner."""

    note: Note


class Reopen(NamedTuple):
    """Open the port again."""


class EndGuardian(NamedTuple):
    """End the guardian.

    Attributes:
        stopped: Whether the robot is known to be stopped, or was never set in motion.
    """

    stopped: bool = True


Action: TypeAlias = ToPort | ToRunner | Reopen | EndGuardian


# --- decisions ------------------------------------------------------------------------------------


BEATS = 6
"""The runner beats this often within the time after which it counts as silent."""

AFTER_A_WRITE_S = 0.03
"""The least time between two frames: two at once would overflow the receiver's ring."""

REPEAT_EVERY_S = 0.1
REOPEN_EVERY_S = 0.5

_ASK_AFTER_S = 0.5
"""A device that confirms nothing for this long is asked for its topics: it may have been reset."""

_LATE_ECHO_S = 0.3
"""An echo may come this late: about four times its time on a healthy link (76 ms)."""


class Guard:
    """Relays between runner and port, and stops the robot when the runner is gone or silent.

    The port counts as closed until :meth:`opened` is called.

    Args:
        instructions: The guardian's instructions from its start.
        epoch_s: Added to the time it gives seconds since 1970, which devices ask for.

    Attributes:
        payload: The safe array; empty while the robot needs no stop.
        acting: Whether the guardian has taken over.
        alone: Whether the runner has gone.
        confirmed: Whether the device has echoed the safe array since the guardian took over.
    """

    def __init__(self, instructions: Instructions, epoch_s: float) -> None:
        self._instructions = instructions
        self._epoch_s = epoch_s
        self._silence_s = instructions.silence_s
        self._patience = SilenceTimer(instructions.silence_s / BEATS)
        self._number: int | None = None
        self._plugged = False
        self._opened_s = -inf
        self._retry_s = inf
        self._wrote_s = -inf
        self._alike_s = -inf
        self._give_up_s = inf
        self.payload = b""
        self.acting = False
        self.alone = False
        self.confirmed = False

    @property
    def due_s(self) -> float:
        """When :meth:`tick` is due if nothing comes before."""
        if not self.acting:
            watch_s = self._patience.due_s(self._silence_s) if self.payload else inf
            return min(self._retry_s, watch_s)
        if self.confirmed:
            return self._retry_s
        due_s = self._conversation.due_s
        if self._safe_frame():
            due_s = min(due_s, self._safe_due_s)
        write_s = max(due_s, self._wrote_s + AFTER_A_WRITE_S) if self._plugged else inf
        return min(self._retry_s, self._give_up_s, write_s)

    # --- the runner -------------------------------------------------------------------------

    def hear(self, note: Note, now: float) -> list[Action]:
        """Return the actions for a note of the runner."""
        self._patience.hear(now)
        match note.kind:
            case NoteKind.LEAVE if not self.acting or self.confirmed:
                return [EndGuardian()]
            case NoteKind.LEAVE:
                return self.runner_gone(now)
            case NoteKind.HEED:
                self.acting = False
            case NoteKind.STOP:
                self.payload = note.body
                self._take_over(now)
            case NoteKind.BEAT:
                if not self.acting:
                    self.payload = _payload_of(note.body)
                return [ToRunner(Note(NoteKind.HEARD))]
            # While the guardian acts, it may be older than what stopped the robot.
            case NoteKind.WRITE if not self.acting:
                return self._relay(note.body, now)
        return []

    def runner_gone(self, now: float) -> list[Action]:
        """Return the actions when the runner has gone, or this process has to end."""
        if not self.payload or (self.acting and self.confirmed):
            return [*self._farewell(), EndGuardian()]
        if not self.alone:
            self.alone = True
            self._give_up_s = now + self._instructions.stay_s
        if not self.acting:
            self._take_over(now)
        return self.tick(now)

    def _relay(self, data: bytes, now: float) -> list[Action]:
        frames = Decoder().feed(data)
        self._wrote_s = now
        if frames and frames[0].topic >= FIRST_OF_THE_DEVICE:
            self._number = frames[0].topic
            if frames[0].payload == self.payload:
                self._alike_s = now
        return [ToPort(data)]

    # --- the port ---------------------------------------------------------------------------

    def opened(self, now: float) -> list[Action]:
        """Handle that the port is open; its device may be new or reset."""
        self._plugged, self._opened_s, self._retry_s = True, now, inf
        if self.acting:
            self._conversation = self._meet(now)
        return [ToRunner(Note(NoteKind.OPENED))]

    def refused(self, reason: str, now: float) -> list[Action]:
        """Handle that the port could not be opened."""
        self._retry_s = now + REOPEN_EVERY_S
        return [ToRunner(Note(NoteKind.REFUSED, reason.encode()))]

    def lost(self, reason: str, now: float) -> list[Action]:
        """Handle that the port has gone."""
        self._plugged, self._retry_s = False, now + REOPEN_EVERY_S
        self._number = None
        return [ToRunner(Note(NoteKind.LOST, reason.encode()))]

    def receive(self, data: bytes, now: float) -> list[Action]:
        """Return the actions for bytes from the port."""
        actions: list[Action] = [] if self.alone else [ToRunner(Note(NoteKind.DATA, data))]
        if not self.acting or self.confirmed:
            return actions
        for _ in self._conversation.receive(data, now):
            pass  # it has learnt numbers of topics
        frames = self._decoder.feed(data)
        if any(self._is_echo(frame, now) for frame in frames):
            self.confirmed = True
            if self.alone:
                return [*actions, *self._farewell(), EndGuardian()]
            actions.append(ToRunner(Note(NoteKind.STOPPED)))
        return actions

    def _is_echo(self, frame: SerialFrame, now: float) -> bool:
        """Return whether this echoes the guardian's own writing, not a recent one of the runner."""
        if frame.payload != self.payload or frame.topic < FIRST_OF_THE_DEVICE:
            return False
        return self._written not in (None, frame.topic) and now > self._alike_s + _LATE_ECHO_S

    # --- time -------------------------------------------------------------------------------

    def tick(self, now: float) -> list[Action]:
        """Return the actions that are due at this time."""
        actions: list[Action] = []
        if not self.acting and self.payload and self._patience.look(now) >= self._silence_s:
            self._take_over(now)
            actions.append(ToRunner(Note(NoteKind.OVERRULED)))
        if now >= self._retry_s:
            self._retry_s = now + REOPEN_EVERY_S
            actions.append(Reopen())
        if self.acting and not self.confirmed:
            if now >= self._give_up_s:
                return [*self._farewell(), EndGuardian(stopped=False)]
            actions += self._insist(now)
        return actions

    def _take_over(self, now: float) -> None:
        self.acting, self.confirmed = True, False
        self._written: int | None = None
        self._conversation = self._meet(now)

    def _meet(self, now: float) -> Conversation:
        """Return a conversation that asks for topics if their numbers are unknown.

        If the runner has written arrays on this connection, its topic number still holds, and the
        device is asked only if it does not answer.
        """
        self._decoder = Decoder()
        self._safe_due_s = now
        wait_s = _ASK_AFTER_S if self._number is not None else 0.0
        boot_s = max(wait_s, self._opened_s + self._instructions.boot_s - now)
        return Conversation(self._instructions.wanted, now, self._epoch_s, boot_s)

    def _insist(self, now: float) -> list[Action]:
        """Return the actions for the next frame towards a confirmed stop, if one may be written."""
        if not self._plugged or now < self._wrote_s + AFTER_A_WRITE_S:
            return []
        data = self._safe_frame() if now >= self._safe_due_s else b""
        if data:
            self._safe_due_s = now + REPEAT_EVERY_S
            self._written = Decoder().feed(data)[0].topic
        else:
            data = self._conversation.write(now)
        if not data:
            return []
        self._wrote_s = now
        return [ToPort(data)]

    def _safe_frame(self) -> bytes:
        """Return the safe frame with the topic number that the device has assigned."""
        frame = self._conversation.frame(self._instructions.array, self.payload)
        if not frame and self._number is not None:
            frame = encode(self._number, self.payload)
        return frame

    def _farewell(self) -> list[Action]:
        return [ToPort(encode(TX_STOP))] if self._plugged and self.payload else []


def _payload_of(frame: bytes) -> bytes:
    frames = Decoder().feed(frame)
    return frames[0].payload if frames else b""
