"""Decide from an incomplete recording and the robot's sensors whether a run can continue.

What was known at the end is found by a replay of what follows the last checkpoint. Its effects must
be those recorded.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from pirate_sm.checking.resume_forecast import Forecast, forecast
from pirate_sm.core.effects import Ended
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import BackendError, RecordingError, UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import HERE, Do, Program
from pirate_sm.core.resuming import (
    FAILURE,
    Reconciled,
    Refused,
    Resumption,
    VerdictTable,
    reconcile,
    resumption,
    unknowns,
)
from pirate_sm.core.spelling import meant
from pirate_sm.running.recording.format.engine_topics import UNLOGGED, Placed
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording, read_end_of_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import Rerun, rerun, same
from pirate_sm.running.wiring import placed
from pirate_sm.running.wiring.adoption import FirstLook, look
from pirate_sm.running.wiring.prepared import Prepared, Say
from pirate_sm.running.wiring.resumed_run import COUNTING, edited, first_wheel_m, lost, said_way

# --- the end of the recording ---------------------------------------------------------------------


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
        for target in program.successors(here):
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


# --- the offer ------------------------------------------------------------------------------------


_MOST_STOPS = 3
"""How often a stop is written and the robot looked at again before an operator must help."""


@dataclass(frozen=True)
class Said:
    """What the operator says.

    Attributes:
        at: Where to resume: ``here``, ``failure`` or a phase.
        states: States of the robot by region.
        start_at_m: Position of the first wheel along the pipe; None if unsaid.
    """

    at: str = HERE
    states: Mapping[str, str] | None = None
    start_at_m: float | None = None

    @property
    def words(self) -> tuple[str, ...]:
        """What is said about the robot, as a recording keeps it."""
        states = tuple(f"{region} is {state}" for region, state in (self.states or {}).items())
        if self.start_at_m is None:
            return states
        return (*states, f"the first wheel is at {self.start_at_m:.3f} m")


class SeenRobot(NamedTuple):
    """A look at the robot, and what it shows.

    Attributes:
        next_id: The number of the next array.
    """

    look: FirstLook
    shows: Reconciled
    next_id: int


class Offer(NamedTuple):
    """What a run would resume with.

    Attributes:
        table: The verdicts about the configuration that counts; None if none does.
        refusals: Why it cannot resume; empty if it can.
        unknown: What the mission depends on and nobody has seen; an operator must agree to it.
        it: What it resumes with; None if it cannot.
        forecast: What can become of it, if that was explored.
        changed: Which files are others than recorded, and what the recording has lost; an operator
            must agree to that too.
        unplaced: Why an operator must say where the robot is before it resumes; empty if not.
    """

    table: VerdictTable | None
    refusals: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    it: Resumption | None = None
    forecast: Forecast | None = None
    changed: tuple[str, ...] = ()
    unplaced: tuple[str, ...] = ()

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why it does not resume without an operator; empty if it does."""
        expected = self.forecast
        if self.refusals or expected is None:
            return self.refusals or ("it is unknown what would become of it",)
        expects = (
            ()
            if expected.word == "possible"
            else (f"the check expects '{expected.word}': {expected.why}",)
        )
        return (*self.changed, *self.unknown, *self.unplaced, *expects)


def check_said(loaded: LoadedMission, said: Said) -> None:
    """Check that phase, regions and states that the operator names are there.

    Raises:
        UsageError: Some are not.
    """
    robot, phases, wrong = loaded.robot, loaded.program.phases, []
    if said.at not in (HERE, FAILURE, *phases):
        known = (HERE, FAILURE, *phases)
        wrong.append(f"--at: the mission has no phase '{said.at}': {meant(said.at, known)}")
    for region, state in (said.states or {}).items():
        if region not in robot.regions:
            wrong.append(f"--state: no region '{region}': {meant(region, robot.regions)}")
            continue
        column = robot.regions.index(region)
        known = tuple(dict.fromkeys(each[column] for each in robot.table.configurations))
        if state not in known:
            wrong.append(f"--state: {region} has no state '{state}': {meant(state, known)}")
    if wrong:
        raise UsageError("\n".join(wrong))


def see(
    prepared: Prepared,
    end: EndOfRun,
    driven_s: float,
    before: SeenRobot | None = None,
    check: Say = lambda text: None,
) -> SeenRobot:
    """Look at the robot, and open the backend first unless that was done.

    Nothing is written but the stop if a wheel turns; the robot is looked at again after it.

    Args:
        prepared: The run that resumes.
        end: Where its recording was cut off.
        driven_s: How long wheels may have been driven meanwhile.
        before: An earlier look.
        check: Is called at every turn with an empty text, and with messages; may raise.

    Raises:
        BackendError: The robot cannot be reached, or a wheel turns on.
    """
    backend, robot, program = prepared.backend, prepared.loaded.robot, prepared.loaded.program
    first = () if before is not None else backend.open()
    now_s = before.look.now_s if before is not None else 0.0
    next_id = before.next_id if before is not None else end.last.robot.next_id + 1
    for _ in range(_MOST_STOPS + 1):
        found = look(backend, first, now_s, lambda: check(""))
        first, now_s = (), found.now_s
        shows = reconcile(robot, program, end.last, found.frames, now_s, driven_s, end.maybe)
        if not shows.turning:
            return SeenRobot(found, shows, next_id)
        check("a wheel turns: the stop is sent, then the robot is looked at again")
        backend.submit(next_id, shows.tables[0].hypothesis.body.values)
        next_id += 1
    raise BackendError("a wheel turns although the stop was sent: look at the robot")


def offer(prepared: Prepared, end: EndOfRun, seen: SeenRobot, said: Said) -> Offer:
    """Return what the run would resume with, or why it cannot.

    Raises:
        UsageError: The operator has said states that the robot cannot have together.
    """
    loaded, shows = prepared.loaded, seen.shows
    table = _said_table(prepared, end, seen, said.states) if said.states else shows.chosen
    refusals = _refusals(shows, table, said)
    if table is None or refusals:
        return Offer(table, refusals or ("no configuration agrees with what is seen",))
    way = said_way(end, shows.way, said.start_at_m)
    it = resumption(
        *(loaded.robot, loaded.program, end.last, end.last_s, table.hypothesis, way, said.at)
    )
    if isinstance(it, Refused):
        return Offer(table, (it.reason,))
    program = it.program(loaded.program)
    unknown, unplaced = unknowns(loaded.robot, program, table), tuple[str, ...]()
    if position := it.unknown_position(loaded.robot, program):
        # Where the recording does not say where it was, nobody can say how far it has come.
        if said.start_at_m is None and first_wheel_m(end) is not None:
            unplaced = (position,)
        else:
            unknown += (position,)
    if prepared.detector in COUNTING and said.start_at_m is None and not way.exact:
        unplaced += (f"where the detector {prepared.detector} counts from: {shows.way.why}",)
    expected = forecast(
        loaded, it, frozenset(each.mark for each in table.verdicts if each.word == "confirmed")
    )
    # Somebody who regrips wants the robot to hold, and knows that the mission fails after it.
    if expected.word == "impossible" or (expected.word == "fails" and said.at != FAILURE):
        reasons = (f"it cannot succeed: {expected.why}",)
        return Offer(table, reasons, (*unknown, *unplaced), None, expected)
    it = it._replace(body=it.body._replace(next_id=seen.next_id))
    changed = (*lost(end.recording), *edited(end.recording.header))
    return Offer(table, (), unknown, it, expected, changed, unplaced)


def counting_from(prepared: Prepared, end: EndOfRun, seen: SeenRobot, said: Said) -> Prepared:
    """Return the run with its detector counting from where the robot is now."""
    was_m, way = first_wheel_m(end), said_way(end, seen.shows.way, said.start_at_m)
    now_m = said.start_at_m
    if now_m is None and was_m is not None and way.exact:
        now_m = was_m + way.low_m
    if now_m is None or prepared.detector not in COUNTING:
        return prepared
    return placed(prepared, now_m)


def _refusals(shows: Reconciled, table: VerdictTable | None, said: Said) -> tuple[str, ...]:
    refusals = shows.refusals if table is shows.chosen or table is None else table.refusals
    if table is None and shows.choices:
        names = " or ".join(_named(each) for each in shows.choices)
        refusals += (f"the sensors agree with {names}: say which with --state",)
    if said.start_at_m is None:
        refusals += tuple(f"{each}: say where it is with --start-at" for each in shows.questions)
    return refusals


def _named(table: VerdictTable) -> str:
    command = table.hypothesis.command
    return f"{command} accepted" if command else "what was recorded"


def _said_table(
    prepared: Prepared, end: EndOfRun, seen: SeenRobot, states: Mapping[str, str]
) -> VerdictTable:
    """Return the verdicts about the states that the operator has said.

    Raises:
        UsageError: The robot has no such configuration.
    """
    robot, recorded = prepared.loaded.robot, seen.shows.tables[0].hypothesis
    names = list(robot.table.configurations[recorded.body.configuration])
    for region, state in states.items():
        names[robot.regions.index(region)] = state
    if tuple(names) not in robot.table.configurations:
        raise UsageError(f"--state: the robot cannot be in {', '.join(names)}")
    there = robot.table.configurations.index(tuple(names))
    said, look = recorded.in_configuration(robot, there, end.last), seen.look
    where = robot, prepared.loaded.program, end.last, look.frames, look.now_s
    return reconcile(*where, 0.0, found=(said,)).tables[0]
