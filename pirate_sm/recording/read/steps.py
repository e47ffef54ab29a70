"""What a recording holds: the steps of the engine, checkpoints, messages for viewers."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from pirate_sm.engine.robot.robot_state import RobotState
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect, WaitArmed
from pirate_sm.model.events import Event


class Step(NamedTuple):
    """Something that the engine was given, and what it gave back.

    Attributes:
        number: Its place in the recording, from 0.
        at_s: When it was on the clock that the engine was given. The runs of a console's session
            share that clock: see :attr:`Recording.origin_s`.
        event: What the engine was given; None for its start and where it was not asked.
        effects: What it gave back; those of the program around it where it was not asked.
        by: ``seen``: shown to the engine at its start, which comes after it. ``start``: the start
            itself. ``engine``: a step of it. ``runtime``: the engine was given up.
        body: Of a start: what an earlier mission had commanded the robot to.
        paused: Of a start: whether the operator had the robot first.
        state: What the engine remembered after it, where the recording says so.
    """

    number: int
    at_s: float
    event: Event | None
    effects: tuple[Effect, ...]
    by: Literal["seen", "start", "engine", "runtime"]
    body: RobotState | None = None
    paused: bool = False
    state: EngineState | None = None


class StepEffects(NamedTuple):
    """The effects of the step of this number; ``at_s`` is the time since the run began."""

    number: int
    at_s: float
    effects: tuple[Effect, ...]


class Message(NamedTuple):
    """A message and its topic; ``time_ns`` is when it was, ns since 1970."""

    topic: str
    time_ns: int
    data: bytes


class Shown(NamedTuple):
    """A message that was made for viewers."""

    topic: str
    at_s: float
    content: dict[str, Any]


class Checkpoint(NamedTuple):
    """The engine's state in the middle of a run, from where it can be executed again.

    Attributes:
        step: The step after which the state was such.
        at_s: When that was, time since the run began.
        state: What the engine remembered then.
        place: Number of the piece of the file that holds it.
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
