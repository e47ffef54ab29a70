"""How a mission is taken up at a phase: under the control that it would have set before."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from pirate_sm.engine.mission.program import Program, SwitchControl
from pirate_sm.engine.mission.successors import successors

_Set = tuple[int, SwitchControl]
"""A control in force, and the instruction that has set it."""


def with_entries(program: Program) -> Program:
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
        waiting += [(target, after) for target in successors(program, at)]
    return found
