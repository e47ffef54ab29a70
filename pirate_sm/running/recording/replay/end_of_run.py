"""Find out what was known when a recording was cut off, so that the mission can go on from there.

Only the part after the last checkpoint is read and replayed. Its effects must be those recorded.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from pirate_sm.core.effects import Ended
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.files import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Do, Program, successors
from pirate_sm.running.recording.format.engine_topics import UNLOGGED
from pirate_sm.running.recording.format.samples import Placed
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording, read_end_of_recording
from pirate_sm.running.recording.replay.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay.replay import Rerun, rerun, same

_SLOW_WITHIN_S = 1.0
"""A disk that was too slow so long before the end may have been so at the end, s [D]."""

_PLACES_WITHIN_S = 1.0
"""How far before the end the wheels must have been seen last, s; they are noted at 10 Hz."""


class EndOfRun(NamedTuple):
    """What was known when a recording was cut off.

    Attributes:
        recording: The recording, without what is before its last checkpoint.
        loaded: The mission as it was run.
        last: The engine's state after the last whole step.
        last_s: Time of that step by the engine's clock, s; ``last_step`` is its number.
        began_s: When the run began by that clock, s.
        maybe: Index of a command that may have been sent after it without being recorded, because
            the disk had been too slow before; None if there is none.
        placed: Where the wheels were last, if that was noted.
    """

    recording: Recording
    loaded: LoadedMission
    last: EngineState
    last_s: float
    last_step: int
    began_s: float
    maybe: int | None
    placed: Placed | None


def end_of_run(path: Path) -> EndOfRun:
    """Return what was known when the recording in this file was cut off.

    Raises:
        RecordingError: The recording cannot be read, its replay differs, nothing was recorded, its
            mission has come to an end, or it cannot be said which command was sent last.
    """
    recording = read_end_of_recording(path)
    with recorded_mission(recording.header) as loaded:
        return _end_of(recording, loaded)


def _end_of(recording: Recording, loaded: LoadedMission) -> EndOfRun:
    name, after = shown(recording.path), recording.checkpoint(recording.until_s)
    unseen = (each for each in recording.gaps if after is None or each.step > after.step)
    if gap := next(unseen, None):
        raise RecordingError(
            f"cannot resume: {name} was damaged from {gap.from_s:.3f} s to "
            f"{gap.until_s:.3f} s, so what the mission knew at its end is unknown"
        )
    last, ended = after.state if after is not None else None, False
    for again in rerun(recording, loaded, after):
        _check(name, again)
        last = again.state
        ended = any(isinstance(effect, Ended) for effect in again.step.effects)
    if last is None:
        raise RecordingError(f"cannot resume: {name} ends before its mission began")
    if ended or last.mission.ended:
        raise RecordingError(
            f"cannot resume: the mission of {name} has come to its end; "
            "run it again, with --from to begin with a phase"
        )
    step, since_s = recording.last_step, recording.until_s - _SLOW_WITHIN_S
    slow = next(recording.messages(UNLOGGED.name, since_s=since_s), None) is not None
    in_flight = last.robot.flight is not None and last.robot.flight.purpose == "gate"
    maybe = None if in_flight or not slow else _next_command(name, loaded, last)
    return EndOfRun(
        *(recording, loaded, last, step.at_s, step.number, recording.origin_s, maybe),
        placed=_placed(recording, loaded),
    )


def _check(name: str, again: Rerun) -> None:
    step = again.step
    differs = not same(step.effects, again.effects)
    if differs or (step.state is not None and not same(step.state, again.state)):
        raise RecordingError(
            f"the replay of {name} differs from it at {again.at_s:.3f} s: what the mission did "
            "cannot be relied on (pirate replay shows the difference)"
        )


def _next_command(name: str, loaded: LoadedMission, last: EngineState) -> int | None:
    """Return the command that the mission may have given next.

    Raises:
        RecordingError: It may have been one of several.
    """
    found = set(_commands_after(loaded.program, last.mission.pc))
    if len(found) > 1:
        names = ", ".join(sorted(loaded.robot.commands[each].name for each in found))
        raise RecordingError(
            f"the disk was too slow for {name} when it ends: one of {names} may have been sent "
            "since, and it is unknown which"
        )
    return next(iter(found), None)


def _commands_after(program: Program, at: int) -> Iterator[int]:
    """Yield the commands to which a way leads from an instruction without another command."""
    seen, pending = {at}, [at]
    while pending:
        here = pending.pop()
        for target in successors(program, here):
            if target < 0 or target in seen:
                continue
            seen.add(target)
            it = program.instructions[target]
            if isinstance(it, Do):
                yield it.command
            else:
                pending.append(target)


def _placed(recording: Recording, loaded: LoadedMission) -> Placed | None:
    """Return where the wheels were last; None if that is unknown or too long ago."""
    since_s = recording.until_s - _PLACES_WITHIN_S
    body = loaded.loaded_robot.profile.body
    last = deque(recorded_places(recording, body, since_s), maxlen=1)
    return next((each for each in last if each.at_s >= since_s), None)
