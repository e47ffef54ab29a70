"""The notes that runner and guardian exchange over their pipe."""

from __future__ import annotations

import json
import struct
from enum import IntEnum
from typing import NamedTuple, Self

from pirate_sm.robot.backends.serial.link.wanted_topics import Wanted

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
