"""Executes a recording again: gives the engine its inputs and compares the effects."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, isnan
from typing import Any, NamedTuple

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.state import EngineState
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model.effects import Effect
from pirate_sm.model.events import SensorFrame, SignalReport
from pirate_sm.recording.read.reader import Recording
from pirate_sm.recording.read.steps import Checkpoint, Step


class Rerun(NamedTuple):
    """A step of a recording and what the engine makes of it now.

    Attributes:
        state: The engine's state after it; None before the start.
        effects: What came of it now; those of the recording where the engine was not asked.
        at_s: When it was, time since the run began.
    """

    step: Step
    state: EngineState | None
    effects: tuple[Effect, ...]
    at_s: float


@dataclass(frozen=True)
class Difference:
    """The first step in which something else comes out than was recorded.

    Attributes:
        step: The step; its ``at_s`` is the time since the run began.
        recorded: Effects of the recording that the replay does not have at this place.
        replayed: Effects of the replay in their place.
        phase: The phase of the mission then; ``place`` its place in the file, if it has one.
        remembers: What the engine remembers otherwise than was recorded, ``sensing.numbers``;
            empty where the effects differ.
    """

    step: Step
    recorded: tuple[Effect, ...]
    replayed: tuple[Effect, ...]
    phase: str
    place: str
    remembers: tuple[str, ...] = ()


@dataclass(frozen=True)
class Replayed:
    """How a replay went.

    Attributes:
        steps: How many were the same.
        effects: How many in these.
        until_s: Time of the last of them.
        difference: The first difference; None where there is none.
        executed: Whether the engine was executed at all.
        from_s: Where it began.
    """

    steps: int
    effects: int
    until_s: float
    difference: Difference | None
    executed: bool = True
    from_s: float = 0.0


def engine_of(recording: Recording, loaded: LoadedMission) -> Engine:
    """Return the engine with the options that it had in the run."""
    return Engine(loaded.robot, loaded.program, nominal=recording.header.nominal)


def rerun(
    recording: Recording, loaded: LoadedMission, after: Checkpoint | None = None
) -> Iterator[Rerun]:
    """Yield every step of the recording, given to the engine again, in order.

    Args:
        recording: What was recorded.
        loaded: The mission.
        after: The checkpoint to begin with; only one of this mission will do. None: the start.

    Raises:
        RecordingError: The recording is damaged.
    """
    state = after.state if after is not None else None
    steps = recording.steps(after)
    return rerun_steps(engine_of(recording, loaded), steps, state, recording.origin_s)


def rerun_steps(
    engine: Engine,
    steps: Iterable[Step],
    state: EngineState | None = None,
    origin_s: float = 0.0,
) -> Iterator[Rerun]:
    """Yield every step, given to the engine again, in order.

    Args:
        engine: As it ran then.
        steps: What it was given.
        state: What it was before the first of them.
        origin_s: When the run began, by the engine's clock.
    """
    seen: list[SensorFrame | SignalReport] = []
    for step in steps:
        effects = step.effects
        if step.by == "seen" and isinstance(step.event, SensorFrame | SignalReport):
            seen.append(step.event)
        elif step.by == "start":
            state, effects = engine.start(step.at_s, seen, body=step.body, paused=step.paused)
        elif step.by == "engine" and state is not None and step.event is not None:
            state, effects = engine.step(state, step.event, step.at_s)
        yield Rerun(step, state, effects, step.at_s - origin_s)


def replay(
    recording: Recording,
    loaded: LoadedMission,
    *,
    changed: bool = False,
    after: Checkpoint | None = None,
    until: Checkpoint | None = None,
    until_s: float = inf,
) -> Replayed:
    """Execute the recording again up to its end or the first difference.

    What the engine remembers is compared, too, wherever the recording holds it.

    Args:
        recording: What was recorded.
        loaded: The mission; the one in the recording, or another one.
        changed: Whether it is another one: then lines and columns of its file do not count.
        after: The checkpoint to begin with; None: the start.
        until: The checkpoint to end with; None: the end.
        until_s: Nothing after this time is executed.

    Raises:
        RecordingError: The recording is damaged.
    """
    from_s = after.at_s if after is not None else 0.0
    done = Replayed(0, 0, from_s, None, executed=False, from_s=from_s)
    for again in rerun(recording, loaded, after):
        step = again.step
        if again.at_s > until_s or (until is not None and step.number > until.step):
            break
        recorded, now = step.effects, again.effects
        if changed:
            recorded, now = _placeless(recorded), _placeless(now)
        remembers = () if changed else _apart(_remembered(step, until), again.state)
        if remembers or not same(recorded, now):
            return replace(done, difference=_difference(again, loaded, remembers))
        done = replace(
            done,
            steps=done.steps + 1,
            effects=done.effects + len(step.effects),
            until_s=again.at_s,
            executed=done.executed or step.by in ("start", "engine"),
        )
    return done


def _remembered(step: Step, until: Checkpoint | None) -> EngineState | None:
    """Return the engine's state after a step as recorded; None where it was not."""
    return until.state if until is not None and until.step == step.number else step.state


def _apart(recorded: Any, now: Any, where: str = "") -> tuple[str, ...]:
    """Return the names of the parts in which two states of the engine differ."""
    if (recorded is None and not where) or same(recorded, now):
        return ()
    if type(recorded) is not type(now) or not hasattr(recorded, "_fields"):
        return (where or "everything",)
    parts = zip(recorded._fields, recorded, now, strict=True)
    inside = [_apart(one, other, f"{where}.{name}".strip(".")) for name, one, other in parts]
    return tuple(each for found in inside for each in found)


_PLACE = re.compile(r":\d+:\d+")


def _placeless(effects: Sequence[Effect]) -> tuple[Any, ...]:
    """Return the effects without lines and columns, which change when a file is edited."""
    return tuple(
        (
            type(effect),
            *(_PLACE.sub("", part) if isinstance(part, str) else part for part in effect),
        )
        for effect in effects
    )


def same(one: Any, other: Any) -> bool:
    """Whether two things of the alphabet are the same; unknown is the same as unknown."""
    if isinstance(one, float) and isinstance(other, float):
        return one == other or (isnan(one) and isnan(other))
    if isinstance(one, tuple) and isinstance(other, tuple):
        return type(one) is type(other) and len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def _difference(again: Rerun, loaded: LoadedMission, remembers: tuple[str, ...]) -> Difference:
    recorded, replayed = _without_common(again.step.effects, again.effects)
    phase = place = ""
    if again.state is not None:
        pc = again.state.mission.pc
        phase = loaded.program.phase_of[pc]
        place = getattr(loaded.program.instructions[pc], "place", "")
    if recorded or replayed:  # these say more
        remembers = ()
    # Its state holds NaN, which is not the same as itself.
    step = again.step._replace(state=None, at_s=again.at_s)
    return Difference(step, recorded, replayed, phase, place, remembers)


def _without_common(
    one: Sequence[Effect], other: Sequence[Effect]
) -> tuple[tuple[Effect, ...], tuple[Effect, ...]]:
    """Return both without what they begin and end with alike."""
    first = 0
    while first < min(len(one), len(other)) and same(one[first], other[first]):
        first += 1
    last = 0
    most = min(len(one), len(other)) - first
    while last < most and same(one[-1 - last], other[-1 - last]):
        last += 1
    return tuple(one[first : len(one) - last]), tuple(other[first : len(other) - last])
