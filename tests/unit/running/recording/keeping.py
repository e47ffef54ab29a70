"""Recorders over files of other kinds, and what is told to them, for the tests beside this."""

from __future__ import annotations

import errno
from collections.abc import Callable
from datetime import UTC, datetime
from functools import cache

from pirate_sm.core import library
from pirate_sm.core.effects import Effect, Ended, Log, Setpoints, WakeAt
from pirate_sm.core.events import Event, SensorFrame, Tick
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.running.recording.format.header import RunHeader, header_of
from pirate_sm.running.recording.write.recorder import Recorder
from pirate_sm.running.recording.write.recording_file import RecordingFile


@cache
def mission() -> LoadedMission:
    return load_mission(library.find_mission("mitre_bend"))


def header(*, viewers: bool = True) -> RunHeader:
    return header_of(
        mission(),
        began=datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC),
        backend="sim",
        nominal=False,
        detector="sim",
        options={"seed": 5},
        viewers=viewers,
    )


class Memory:
    """Takes bytes; fails as it is told to."""

    def __init__(self, room: float = float("inf"), wait: Callable[[], None] | None = None) -> None:
        self.data = b""
        self.closed = False
        self._room = room
        self._wait = wait or (lambda: None)

    def write(self, data: bytes, /) -> None:
        self._wait()
        left = self._room - len(self.data)
        if len(data) > left:
            self.data += data[: max(0, int(left))]
            raise OSError(errno.ENOSPC, "No space left on device")
        self.data += data

    def close(self) -> None:
        self.closed = True


def recorder(memory: Memory, *, real_time: bool = False, commit_s: float = 3600.0) -> Recorder:
    """One that commits at its end only, unless told otherwise."""
    begun = header()
    return Recorder(RecordingFile(memory, begun), begun, real_time=real_time, commit_s=commit_s)


Told = tuple[Event, float, tuple[Effect, ...]]


def course(steps: int) -> list[Told]:
    """So many steps of a run that never was."""
    told: list[Told] = []
    for number in range(steps):
        at_s = number * 0.016
        event: Event = SensorFrame(22, tuple(number + share / 8 for share in range(6)))
        effects: tuple[Effect, ...] = ()
        if number % 5 == 1:
            event = Tick()
            effects = (WakeAt(at_s + 1 / 3), Setpoints(number, (0.1 * number,) * 18))
        told.append((event, at_s, effects))
    told.append((Tick(), steps * 0.016, (Log("info", "over"), Ended("succeeded", "there", "far"))))
    return told


def tell(one: Recorder, told: list[Told]) -> None:
    """The recorder has been told of a start and of all this."""
    one.start((), 0.0, (WakeAt(0.5),))
    for event, at_s, effects in told:
        one.take(event, at_s, effects)
