"""A device at the other end of a pseudo-terminal that talks all the time, as a real one does.

It answers with the emulated bay's half of the protocol: the node handle and the byte-wise reader of
the firmware. What both ends share is held to captured frames in ``tests/unit/robot/rosserial``.
"""

from __future__ import annotations

import os
import select
import struct
import threading
import time
import tty
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from pirate_sm.robot.backends.serial.link.conversation import Wanted
from pirate_sm.robot.rosserial.frames import Direction, SerialFrame, TopicInfo, encode
from pirate_sm.simulation.bay.node_handle import NodeHandle, Reception

PATIENCE_S = 10.0
TALKS_EVERY_S = 1 / 25

ECHO, STATE, ARRAY = "echo", "state", "setpoints"
TYPE, MD5 = "pirate_msgs/{}", "0123456789abcdef" * 2
FIRST_PUBLISHER, FIRST_SUBSCRIBER = 125, 100
WANTED = (
    Wanted(ARRAY, TYPE.format(ARRAY), MD5, "takes"),
    Wanted(ECHO, TYPE.format(ECHO), MD5, "publishes"),
    Wanted(STATE, TYPE.format(STATE), MD5, "publishes"),
)


def topic(number: int, name: str) -> TopicInfo:
    way: Direction = "takes" if name == ARRAY else "publishes"
    return TopicInfo(number, name, TYPE.format(name), MD5, 512, way)


class Bench:
    """A port, and the device behind it in a thread of its own; a context manager.

    Args:
        link: The port's name, which stays when the device is unplugged and plugged in again.
        echoes: Whether it says what it has applied.
        talks: Whether it publishes its state at 25 Hz without having been asked for its topics.

    Attributes:
        frames: When each frame came from the host, and what it was.
        applied: Payloads of the arrays that it has obeyed, with their times.
        asked: How often it has been asked for its topics.
        faults: What the host must not have done, in words.
    """

    def __init__(self, link: Path, *, echoes: bool = True, talks: bool = True) -> None:
        self.link = link
        self.echoes = echoes
        self.hears = True
        self.frames: list[tuple[float, int, bytes]] = []
        self.applied: list[tuple[float, bytes]] = []
        self.asked = 0
        self.faults: list[str] = []
        self._changed = threading.Condition()
        self._ends = False
        self._ours = -1
        self._talks = talks
        self._say: list[bytes] = []
        self._plug(0)
        self._thread = threading.Thread(target=self._run, name="bench", daemon=True)

    @property
    def name(self) -> str:
        return str(self.link)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ends = True
        self._thread.join(PATIENCE_S)
        self.unplug()
        assert kind is not None or not self.faults, self.faults

    # --- what a test does ---------------------------------------------------------------------

    def unplug(self) -> None:
        """The port is gone."""
        with self._changed:
            if self._ours >= 0:
                os.close(self._ours)
                os.close(self._theirs)
                self._ours = -1
            self.link.unlink(missing_ok=True)

    def plug(self, shift: int = 0) -> None:
        """The port is there again; the device has been reset, its topics' numbers shifted."""
        with self._changed:
            self._talks = False
            self._plug(shift)

    def say(self, data: bytes) -> None:
        """The device has put these bytes on the line."""
        with self._changed:
            self._say.append(data)

    def hear(self, payload: bytes) -> float:
        """When an array with this payload was first obeyed.

        Raises:
            AssertionError: It never was.
        """
        self.wait(lambda: any(heard == payload for _, heard in self.applied), repr(payload))
        return next(at_s for at_s, heard in self.applied if heard == payload)

    def wait(self, true: Callable[[], bool], what: str) -> None:
        """It has become true.

        Raises:
            AssertionError: It never has.
        """
        with self._changed:
            if not self._changed.wait_for(true, PATIENCE_S):
                raise AssertionError(f"never: {what}; only {self.applied[-5:]}")

    # --- the device ---------------------------------------------------------------------------

    def _plug(self, shift: int) -> None:
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(self._theirs))
        self._array = FIRST_SUBSCRIBER + shift
        self._echo, self._state = FIRST_PUBLISHER + shift, FIRST_PUBLISHER + shift + 1
        publishers = topic(self._echo, ECHO), topic(self._state, STATE)
        self._node = NodeHandle(publishers, (topic(self._array, ARRAY),))
        self._reception = Reception()
        if self._talks:
            self._node.take(SerialFrame(0, b""), time.monotonic())

    def _run(self) -> None:
        next_s = time.monotonic()
        while not self._ends:
            ours = self._ours
            with suppress(OSError, ValueError):
                select.select([ours] if ours >= 0 else [], [], [], 0.005)
            with self._changed:
                now = time.monotonic()
                if self._ours >= 0:
                    self._receive(now)
                    if now >= next_s:
                        next_s = max(next_s + TALKS_EVERY_S, now)
                        self._publish(now)
                self._changed.notify_all()

    def _publish(self, now: float) -> None:
        for frame in self._node.tick(now):
            self._write(encode(*frame))
        if self._node.configured:
            self._write(encode(self._state, struct.pack("<d", now)))
        for data in self._say:
            self._write(data)
        self._say.clear()

    def _receive(self, now: float) -> None:
        with suppress(OSError):
            data = os.read(self._ours, 4096)
            if self.hears:
                for frame in self._reception.feed((byte, now) for byte in data):
                    self._take(frame, now)

    def _take(self, frame: SerialFrame, now: float) -> None:
        self.frames.append((now, frame.topic, frame.payload))
        self.asked += frame.topic == 0
        answer = self._node.take(frame, now)
        if answer.fault:
            self.faults.append(answer.fault)
        for said in answer.says:
            self._write(encode(*said))
        if frame.topic == self._array:
            self.applied.append((now, frame.payload))
            if self.echoes and self._node.configured:
                self._write(encode(self._echo, frame.payload))

    def _write(self, data: bytes) -> None:
        with suppress(OSError):  # nobody reads, as on a real port
            os.write(self._ours, data)
