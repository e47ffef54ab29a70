"""Look at a robot before a mission goes on: read every board for a while, write only a stop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.core.events import Event, FaultReport, SensorFrame

if TYPE_CHECKING:
    from pirate_sm.robot.backends.protocol import Backend

LOOK_S = 1.0
"""How long the boards are read: a clamp must have been seen for half a second [D]."""


class FirstLook(NamedTuple):
    """What the boards have reported.

    Attributes:
        began_s: When the look began, by the backend's mission time; ``now_s`` is its end.
        frames: The frames of the boards, with their times, s.
        faults: What was wrong with the link and the boards.
    """

    began_s: float
    now_s: float
    frames: tuple[tuple[float, SensorFrame], ...]
    faults: tuple[FaultReport, ...]

    @property
    def newest(self) -> tuple[SensorFrame, ...]:
        """The last frame of each board."""
        return tuple({frame.board: frame for _, frame in self.frames}.values())


def look(
    backend: Backend,
    first: Sequence[Event] = (),
    began_s: float = 0.0,
    check: Callable[[], None] = lambda: None,
    for_s: float = LOOK_S,
) -> FirstLook:
    """Read the boards for a while; nothing is written.

    Args:
        backend: The backend, opened.
        first: Its first events.
        began_s: Its mission time.
        check: Is called at every turn; may raise, to end the look.
        for_s: How long the boards are read.

    Raises:
        BackendError: The backend has failed.
    """
    now_s, events = began_s, first
    frames: list[tuple[float, SensorFrame]] = []
    faults: list[FaultReport] = []
    while True:
        for event in events:
            if isinstance(event, SensorFrame):
                frames.append((now_s, event))
            elif isinstance(event, FaultReport):
                faults.append(event)
        if now_s >= began_s + for_s:
            return FirstLook(began_s, now_s, tuple(frames), tuple(dict.fromkeys(faults)))
        check()
        now_s, events = backend.advance(began_s + for_s)
