"""What the guardian of a port decides: when the runner falls silent, it stops the robot itself.

Pure: what comes from the runner and from the port goes in with the time, what is to be done comes
out. The process around it is :mod:`pirate_sm.backends.pico.guardian`.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from math import inf
from typing import NamedTuple, TypeAlias

from pirate_sm.backends.pico.framing import Decoder, encode
from pirate_sm.backends.pico.topics import TX_STOP

_HEADER = struct.Struct("<BI")
_LONGEST = 1 << 20

AFTER_A_WRITE_S = 0.03
"""Two frames at once would not fit into the ring of the receiver."""

REPEAT_EVERY_S = 0.1
REPEATS = 50
"""A controller that is being reset hears none of the first half. With three of four echoes lost,
one of the others is seen to arrive but for 1 in 1,000."""


class Kind(IntEnum):
    """What runner and guardian say to each other."""

    WRITE = 1
    BEAT = 2
    REOPEN = 3
    HEED = 4
    LEAVE = 5
    DATA = 16
    OPENED = 17
    REFUSED = 18
    LOST = 19
    OVERRULED = 20


class Note(NamedTuple):
    """One thing that one of the two says.

    Attributes:
        body: Bytes of the port, the safe frame, or words for people.
    """

    kind: Kind
    body: bytes = b""

    def to_bytes(self) -> bytes:
        """How it travels."""
        return _HEADER.pack(self.kind, len(self.body)) + self.body


class NoteReader:
    """Finds the notes in what comes through the pipe."""

    def __init__(self) -> None:
        self._pending = b""

    def feed(self, data: bytes) -> list[Note]:
        """The notes that these bytes complete.

        Raises:
            ValueError: This is no pipe of ours.
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
            notes.append(Note(Kind(kind), self._pending[_HEADER.size : end]))
            self._pending = self._pending[end:]
        return notes


class ToPort(NamedTuple):
    """Bytes to be written in one call."""

    data: bytes


class ToRunner(NamedTuple):
    """A note to be passed on."""

    note: Note


class Reopen(NamedTuple):
    """The port is to be opened again."""


class Finish(NamedTuple):
    """There is nothing left to guard."""


Action: TypeAlias = ToPort | ToRunner | Reopen | Finish


class Guard:
    """Relays, and acts when it must.

    Args:
        silence_s: The runner must be heard within so long.

    Attributes:
        acting: Whether it has taken over.
    """

    def __init__(self, silence_s: float) -> None:
        self._silence_s = silence_s
        self._safe_frame = b""
        self._heard_s = inf
        self._wrote_s = -inf
        self._alone = False
        self._left = 0
        self._repeat_s = inf
        self._decoder = Decoder()
        self.acting = False

    @property
    def due_s(self) -> float:
        """When it wants to be asked, if nothing comes before."""
        if self.acting:
            return self._repeat_s
        return self._heard_s + self._silence_s if self._safe_frame else inf

    def hear(self, note: Note, now: float) -> list[Action]:
        """What a note of the runner makes it do."""
        self._heard_s = now
        if note.kind == Kind.LEAVE:
            return [Finish()]
        if note.kind == Kind.HEED:
            self.acting = False
        elif note.kind == Kind.REOPEN:
            return [Reopen()]
        elif self.acting:
            return []  # it may have been written before the runner stood still
        elif note.kind == Kind.BEAT:
            self._safe_frame = note.body
        elif note.kind == Kind.WRITE:
            self._wrote_s = now
            return [ToPort(note.body)]
        return []

    def bereave(self, now: float) -> list[Action]:
        """The runner has gone for good, or this process is told to end."""
        self._alone = True
        if not self._safe_frame:
            return [Finish()]
        if self.acting and self._repeat_s == inf:
            return [ToPort(encode(TX_STOP)), Finish()]  # the robot is safe already
        if not self.acting:
            self._take_over(now)
        return self.tick(now)

    def receive(self, data: bytes, now: float) -> list[Action]:
        """What has come from the port."""
        actions: list[Action] = [] if self._alone else [ToRunner(Note(Kind.DATA, data))]
        if not self.acting:
            return actions
        frames = self._decoder.feed(data)
        wanted = self._safe_payload
        if wanted and any(frame.payload == wanted for frame in frames):
            self._left = 0
            self._repeat_s = inf
            if self._alone:
                actions += [ToPort(encode(TX_STOP)), Finish()]
        return actions

    def tick(self, now: float) -> list[Action]:
        """What the time makes it do."""
        actions: list[Action] = []
        if not self.acting and now >= self.due_s:
            self._take_over(now)
            actions.append(ToRunner(Note(Kind.OVERRULED)))
        if self.acting and now >= self._repeat_s:
            if self._left:
                self._left -= 1
                self._repeat_s = now + REPEAT_EVERY_S
                actions.append(ToPort(self._safe_frame))
            else:
                self._repeat_s = inf
                if self._alone:
                    actions += [ToPort(encode(TX_STOP)), Finish()]
        return actions

    def _take_over(self, now: float) -> None:
        self.acting = True
        self._decoder = Decoder()
        self._left = REPEATS
        self._repeat_s = max(now, self._wrote_s + AFTER_A_WRITE_S)

    @property
    def _safe_payload(self) -> bytes:
        frames = Decoder().feed(self._safe_frame)
        return frames[0].payload if frames else b""
