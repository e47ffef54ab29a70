"""Replays a recording: gives the engine its inputs again and compares the effects."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, isnan
from typing import Any, NamedTuple

from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.events import Breakpoints, SensorFrame, SignalReport
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import BranchKey
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.pieces import Checkpoint, Gap, RecordedStep
from pirate_sm.running.recording.read.reader import Recording


class Rerun(NamedTuple):
    """A step of a recording and its result in the replay.

    Attributes:
        state: The engine's state after it; None before the start.
        effects: The effects in the replay; the recorded ones for actions past the engine.
        at_s: Time since the run began.
    """

    step: RecordedStep
    state: EngineState | None
    effects: tuple[Effect, ...]
    at_s: float


@dataclass(frozen=True)
class Difference:
    """The first step whose result differs from the recording.

    Attributes:
        step: The step; its ``at_s`` is the time since the run began.
        recorded: Recorded effects that the replay does not have at this point.
        replayed: Effects of the replay in their place.
        phase: The phase of the mission then; ``place`` is its place in the file, if it has one.
        remembers: Names of the parts of the engine's state that differ, ``sensing.numbers``;
            empty if the effects differ.
    """

    step: RecordedStep
    recorded: tuple[Effect, ...]
    replayed: tuple[Effect, ...]
    phase: str
    place: str
    remembers: tuple[str, ...] = ()


@dataclass(frozen=True)
class Replayed:
    """The result of a replay.

    Attributes:
        steps: Number of equal steps.
        effects: Number of effects in these.
        until_s: Time of the last of them.
        difference: The first difference; None if there is none.
        executed: Whether the engine was executed at all.
        from_s: Time at which the replay began.
        gap: The gap of a repaired recording at which the replay stopped; None if it did not.
    """

    steps: int
    effects: int
    until_s: float
    difference: Difference | None
    executed: bool = True
    from_s: float = 0.0
    gap: Gap | None = None


def engine_of(
    header: RunHeader,
    loaded: LoadedMission,
    *,
    every_signal: bool = False,
    taken: list[BranchKey] | None = None,
) -> Engine:
    """Return the engine with the options of the run; ``taken`` receives branches of the mission."""
    return Engine(
        loaded.robot,
        loaded.program,
        nominal=header.nominal,
        every_signal=every_signal,
        alphabet=header.alphabet,
        taken=taken,
    )


def rerun(
    recording: Recording,
    loaded: LoadedMission,
    after: Checkpoint | None = None,
    *,
    every_signal: bool = False,
) -> Iterator[Rerun]:
    """Yield every step of the recording, replayed, in order.

    Args:
        recording: The recording.
        loaded: The mission.
        after: The checkpoint of this mission to begin with; None: the start.
        every_signal: Whether states have every signal, also those that nothing read in the run.

    Raises:
        RecordingError: The recording is damaged.
    """
    state = after.state if after is not None else None
    steps = recording.steps(after)
    engine = engine_of(recording.header, loaded, every_signal=every_signal)
    return rerun_steps(engine, steps, recording.gaps, state, recording.origin_s)


def rerun_steps(
    engine: Engine,
    steps: Iterable[RecordedStep],
    gaps: Iterable[Gap],
    state: EngineState | None = None,
    origin_s: float = 0.0,
) -> Iterator[Rerun]:
    """Yield every step, replayed, in order.

    After a gap the mission is not executed until the engine's recorded state is known: of the
    signals those are known then that follow from frames alone, of the robot and the mission what
    is recorded, and nothing is confirmed before a recorded change says so.

    Args:
        engine: The engine as in the run.
        steps: The recorded steps.
        gaps: The gaps between them.
        state: The engine's state before the first of them.
        origin_s: When the run began, by the engine's clock.
    """
    after_gaps, is_lost = {gap.step for gap in gaps}, False
    seen: list[SensorFrame | SignalReport | Breakpoints] = []
    for step in steps:
        effects = step.effects
        if step.number in after_gaps:
            is_lost, state = True, engine.unproven(state)
        if is_lost and state is not None:
            state = step.state or engine.listening_only(state, step.event, step.effects, step.at_s)
            is_lost = step.state is None
        elif step.by == "seen" and isinstance(step.event, SensorFrame | SignalReport | Breakpoints):
            seen.append(step.event)
        elif step.by == "start":
            state, effects = engine.start(
                step.at_s, seen, body=step.body, paused=step.paused, resumed=step.resumed
            )
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
    """Replay the recording up to its end or the first difference.

    The engine's state is compared too, wherever the recording contains it.

    Args:
        recording: The recording.
        loaded: The mission in the recording, or another one.
        changed: Whether it is another one; then lines and columns of its file are not compared.
        after: The checkpoint to begin with; None: the start.
        until: The checkpoint to end with; None: the end.
        until_s: Steps after this time are not replayed.

    Raises:
        RecordingError: The recording is damaged.
    """
    from_s = after.at_s if after is not None else 0.0
    done = Replayed(0, 0, from_s, None, executed=False, from_s=from_s)
    for again in rerun(recording, loaded, after):
        step = again.step
        if again.at_s > until_s or (until is not None and step.number > until.step):
            break
        if gap := next((gap for gap in recording.gaps if gap.step == step.number), None):
            return replace(done, gap=gap)
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


def _remembered(step: RecordedStep, until: Checkpoint | None) -> EngineState | None:
    """Return the recorded state of the engine after a step; None if there is none."""
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
    """Return whether two events, effects or values are equal; unknown equals unknown."""
    if one is other:  # most steps have no effects: the same empty tuple
        return True
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
    if recorded or replayed:  # these explain more
        remembers = ()
    # The step's state contains NaN, which does not equal itself.
    step = again.step._replace(state=None, at_s=again.at_s)
    return Difference(step, recorded, replayed, phase, place, remembers)


def _without_common(
    one: Sequence[Effect], other: Sequence[Effect]
) -> tuple[tuple[Effect, ...], tuple[Effect, ...]]:
    """Return both without their common beginning and end."""
    first = 0
    while first < min(len(one), len(other)) and same(one[first], other[first]):
        first += 1
    last = 0
    most = min(len(one), len(other)) - first
    while last < most and same(one[-1 - last], other[-1 - last]):
        last += 1
    return tuple(one[first : len(one) - last]), tuple(other[first : len(other) - last])
