"""The records in a recording: steps of the engine, checkpoints, messages for viewers."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from pirate_sm.core.effects import Effect, WaitArmed
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event
from pirate_sm.core.resuming import Resumption
from pirate_sm.core.robot import RobotState


class RecordedStep(NamedTuple):
    """An input of the engine and its effects.

    Attributes:
        number: Its number in the recording, from 0.
        at_s: Its time by the engine's clock. The runs of a console's session share that clock: see
            :attr:`Recording.origin_s`.
        event: The input; None for the start and for actions past the engine.
        effects: The engine's effects; those of the program around it for actions past the engine.
        by: ``seen``: known to the engine before its start. ``start``: the start itself.
            ``engine``: a step of the engine. ``runtime``: an action past the engine.
        body: For a start: the robot state after an earlier mission.
        paused: For a start: whether the operator controlled the robot first.
        state: The engine's state after it, if it was recorded.
        resumed: For a start: with what a mission went on whose run was cut off.
    """

    number: int
    at_s: float
    event: Event | None
    effects: tuple[Effect, ...]
    by: Literal["seen", "start", "engine", "runtime"]
    body: RobotState | None = None
    paused: bool = False
    state: EngineState | None = None
    resumed: Resumption | None = None


class Gap(NamedTuple):
    """Steps in the middle of a repaired recording that were damaged, so that they are not in it.

    Attributes:
        step: Number of the first step after it.
        from_s: Time of the last step before it, since the run began; 0 if it is at the start.
        until_s: Time of the first step after it.
    """

    step: int
    from_s: float
    until_s: float


class StepEffects(NamedTuple):
    """The effects of the step with this number; ``at_s`` is the time since the run began."""

    number: int
    at_s: float
    effects: tuple[Effect, ...]


class Message(NamedTuple):
    """A message and its topic; ``time_ns`` is its time, ns since 1970."""

    topic: str
    time_ns: int
    data: bytes


class ViewerMessage(NamedTuple):
    """A message for viewers."""

    topic: str
    at_s: float
    content: dict[str, Any]


class Checkpoint(NamedTuple):
    """The engine's state in the middle of a run, from which a replay can begin.

    Attributes:
        step: The last step before this state.
        at_s: Time since the run began.
        state: The engine's state.
        place: Number of the piece of the file that contains it.
    """

    step: int
    at_s: float
    state: EngineState
    place: int = 0


def with_own_times(effects: tuple[Effect, ...], origin_s: float) -> tuple[Effect, ...]:
    """Return the effects with deadlines that count from the origin of a recording."""
    return tuple(
        it._replace(deadline_s=it.deadline_s - origin_s) if isinstance(it, WaitArmed) else it
        for it in effects
    )
