"""Frames that change only signals: what must stay true meanwhile, and the state after them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from math import inf
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.records import Numbers, often_replaced
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.environment import Surveyed
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._expressions.compiler import Code
from pirate_sm.core._model.events import Event, FrameBlock, SensorFrame
from pirate_sm.core._model.whereabouts import Look, Trail
from pirate_sm.core.effects import Effect

# --- what must stay true ----------------------------------------------------------------------


ANY_BOARD = -1
"""Instead of boards: every one."""


class Condition(NamedTuple):
    """A condition that a frame must leave as it is.

    Attributes:
        code: The condition.
        holds: Whether it is true now; otherwise it is false or unknown.
        boards: The boards after whose frames it is asked, as bits by their positions.
    """

    code: Code
    holds: bool
    boards: int


class SameDuty(NamedTuple):
    """A position loop that must give the duty that was sent last.

    Attributes:
        angle: Number index of the controlled angle.
        target_rad: The angle to reach.
        gain: As in ``PositionSpec``; so are ``threshold_rad``, ``least_duty`` and ``limit``.
        resolution: Steps of the wire.
        sent: The duty that was sent last.
    """

    angle: int
    target_rad: float
    gain: float
    threshold_rad: float
    least_duty: float
    limit: float
    resolution: float
    sent: float


@often_replaced
class Watch(NamedTuple):
    """What a frame meets, and what it must leave as it is; else the engine must take it.

    A frame is quiet if its values are plausible, it comes before the deadline, every condition of
    its board is as before, and every loop gives the duty that was sent last. It changes nothing but
    :class:`Glided`.

    Attributes:
        robot: The robot.
        sensing: The signals before the frame.
        setpoints: Values in force per slot.
        latest: Values last sent, which may be in force already.
        asked: The array by which motions are judged, the last that was sent; empty before.
        origin: Signals when the wait began, for conditions on their changes; else empty.
        rules: The fault rules; the same object where they are the same again.
        conditions: The other conditions.
        duties: The loops.
        surveyed: What the survey of the pipe remembers, which is made again when it is due.
        held: The held parts by which it is made.
        in_bend: Whether a word has announced a bend that is not passed yet.
        frames_until_s: From when on no frame is quiet.
        wake_s: When the engine has asked to be called; what follows is what that is made of.
        deadline_s: When something else than the following two is due.
        word: The detector's valid word, if any; ``word_until_s``: until when.
        alarm_s: When the engine must be called although no event comes.
        listening_s: When silent boards are looked for next, which happens at intervals as long as
            all have reported; infinite where the engine must do it.
    """

    robot: RobotSpec
    sensing: Sensing
    setpoints: Numbers
    latest: Numbers
    asked: Numbers
    origin: Numbers
    rules: tuple[Condition, ...]
    conditions: tuple[Condition, ...]
    duties: tuple[SameDuty, ...]
    surveyed: Surveyed
    held: tuple[int, ...]
    in_bend: bool
    frames_until_s: float
    wake_s: float
    deadline_s: float
    word: str | None
    word_until_s: float
    alarm_s: float
    listening_s: float


# --- what is so after them --------------------------------------------------------------------


class Glided(NamedTuple):
    """What quiet frames change.

    Attributes:
        sensing: The signals.
        surveyed: What the survey remembers.
        wake_at_s: The next time at which something changes without an event.
        word_until_s: The end of the validity of the detector's word.
    """

    sensing: Sensing
    surveyed: Surveyed
    wake_at_s: float
    word_until_s: float

    def applied_to(self, state: EngineState) -> EngineState:
        """Return the state after these frames, which left true what was watched.

        It is the state that the engine returns after the same frames, which have no effects.
        """
        return state._replace(**self._asdict())


Step: TypeAlias = tuple[float, Event, tuple[Effect, ...]]
"""A step of the engine: its time, its event, its effects."""


class Glide(NamedTuple):
    """Cycles that have passed without the engine.

    Attributes:
        now_s: The time reached.
        after: The signals after them; None where nothing has been taken.
        frames: The frames that were taken.
        steps: What else has happened, with time, event and effects: silent boards were looked for,
            which may be in the step of one of the frames, or the detector's word was repeated.
        looks: The looks that were made for a detector.
        due_s: When its next one is due.
        said_s: When its word was repeated last; None if it was not.
        trail: Where the robot was at each step; None where nobody knows.
    """

    now_s: float
    after: Glided | None
    frames: FrameBlock
    steps: Sequence[Step] = ()
    looks: Sequence[Look] = ()
    due_s: float = inf
    said_s: float | None = None
    trail: Trail | None = None

    def times_s(self) -> Sequence[float]:
        """Return the times of all steps in their order, s; of a frame twice if it has effects."""
        if not self.steps:
            return self.frames.times_s
        return sorted((*self.frames.times_s, *(step[0] for step in self.steps)))

    def in_order(self) -> Iterator[Step]:
        """Yield all steps, those of the frames too, in the order of time.

        A step of a frame takes the place of this frame; any other one comes after the frames of
        its time.
        """
        frames, begin = self.frames, 0
        for step in self.steps:
            end = bisect_right(frames.times_s, step[0])
            own = isinstance(step[1], SensorFrame)
            yield from _quiet(frames, begin, end - own)
            yield step
            begin = end
        yield from _quiet(frames, begin, len(frames))


def _quiet(frames: FrameBlock, begin: int, end: int) -> Iterator[Step]:
    for at in range(begin, end):
        yield frames.times_s[at], frames.frame(at), ()
