"""Compile a mission and the missions that it calls into one flat program."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import replace
from math import inf

from pirate_sm.core._engine.mission import program as out
from pirate_sm.core._engine.mission.program import Program, SwitchControl
from pirate_sm.core._loading.mission.called_missions import start_configuration
from pirate_sm.core._loading.mission.parameter_values import Values
from pirate_sm.core._loading.mission.program_writer import (
    MOST_INSTRUCTIONS,
    Assembly,
    ProgramWriter,
    TooLongError,
)
from pirate_sm.core._loading.mission.scope import Label, Scope, Source, labels_of
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.robot.commands import rules_for
from pirate_sm.core._loading.robot.loader import LoadedRobot
from pirate_sm.core._loading.yaml.document import Document
from pirate_sm.core.on_disk import resolved


def build_program(
    source: Source,
    robot: LoadedRobot,
    values: Values,
    start_phase: str | None,
    states: Mapping[str, str] | None,
    problems: Problems,
    tolerated: Collection[str] = (),
) -> tuple[Program, tuple[Document, ...]]:
    """Return the mission's program, and the files of the missions that it calls.

    Steps whose fault has a tolerated code are left out.

    Raises:
        LoadError: The mission has faults; holds all of them.
        UsageError: ``states`` do not fit the robot.
    """
    mission = source.mission
    at_start = start_configuration(source, robot.table, states, problems)
    writer = ProgramWriter(robot, Assembly())
    scope = _outermost(source, robot, values, problems)
    start = writer.beginning(scope, mission.start)
    limit = scope.limit(mission.time_limit, ("time_limit",))
    _write(writer, scope, start, problems)
    problems.raise_errors(tolerated)
    instructions, handlers, phase_of, turn_of = writer.assembly.finished()
    program = Program(
        instructions,
        start.index,
        at_start,
        handlers,
        tuple(writer.names),
        phase_of,
        inf if limit is None else limit,
        rules_for(mission, robot.rules),
        turn_of=turn_of,
    )
    program = _with_entries(program)
    begin = program.beginning(start_phase) if start_phase else None
    if begin is not None and start_phase != mission.start:
        program = replace(program, start=begin)
    return program, tuple(writer.calls.files.values())


def _outermost(source: Source, robot: LoadedRobot, values: Values, problems: Problems) -> Scope:
    """Return the scope of the mission itself, which has no caller."""
    mission = source.mission
    return Scope(
        source,
        robot.believed,
        robot.oriented(mission.polarity or "normal"),
        problems.about(source.document),
        "",
        values,
        labels_of(mission),
        out.STOP,
        (),
        (resolved(source.path),),
    )


def _write(writer: ProgramWriter, scope: Scope, start: Label, problems: Problems) -> None:
    """Write all instructions of the mission, or report that there are too many."""
    try:
        if writer.calls.least_length(scope.source) > MOST_INSTRUCTIONS:
            raise TooLongError
        writer.begin(scope, scope.source.mission.start, start)
        writer.ends(scope)
        writer.phases(scope)
    except TooLongError as error:
        about, path = error.by or (problems, ())
        count = f"more than {MOST_INSTRUCTIONS} steps"
        message = f"with its repeats and calls written out it has {count}"
        about.add("mission.too_long", path, message)


_Set = tuple[int, SwitchControl]
"""A control in force, and the instruction that has set it."""


def _with_entries(program: Program) -> Program:
    """Return the program with an entry to each phase for each control that may be in force there.

    A mission that is begun at a later phase, or handed back there, has not run what sets its
    control. An entry sets it first. Entries stand behind all other instructions, which do not lead
    to them. A mission without controls needs none.
    """
    first = next((each for each in program.instructions if isinstance(each, SwitchControl)), None)
    if first is None:
        return program
    extra: list[SwitchControl] = []
    homes: list[int] = []
    entries: dict[str, list[tuple[int, int]]] = {}
    for at, (control, setter) in _controls_at_phases(program, first):
        place = len(program.instructions) + len(extra)
        entries.setdefault(program.phase_of[at], []).append((control, place))
        failed = program.entered(at).failed
        extra.append(setter._replace(control=control, next=at, failed=failed))
        homes.append(at)
    return replace(
        program,
        instructions=(*program.instructions, *extra),
        handlers=(*program.handlers, *(program.handlers[at] for at in homes)),
        phase_of=(*program.phase_of, *(program.phase_of[at] for at in homes)),
        turn_of=(*program.turn_of, *("" for _ in homes)),
        entries={phase: tuple(each) for phase, each in entries.items()},
    )


def _controls_at_phases(program: Program, first: SwitchControl) -> list[tuple[int, _Set]]:
    """Return the beginning of each phase with each control in force there, the nearest way first.

    ``first`` stands for what has set the usual control, which no instruction has.
    """
    begins = {program.enter(phase) for phase in program.phases}
    found: list[tuple[int, _Set]] = []
    seen: set[tuple[int, int]] = set()
    waiting: deque[tuple[int, _Set]] = deque([(program.start, (0, first))])
    while waiting:
        at, in_force = waiting.popleft()
        if at < 0 or (at, in_force[0]) in seen:
            continue
        seen.add((at, in_force[0]))
        if at in begins:
            found.append((at, in_force))
        step = program.instructions[at]
        after = (step.control, step) if isinstance(step, SwitchControl) else in_force
        waiting += [(target, after) for target in program.successors(at)]
    return found
