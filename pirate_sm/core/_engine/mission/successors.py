"""Where each instruction of a program may lead."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.core._engine.mission import program as steps
from pirate_sm.core._engine.mission.program import Program


def successors(program: Program, at: int, *, fires: bool = True) -> Iterator[int]:
    """Yield the targets of an instruction: those of success, of failures, of fault handlers.

    Args:
        program: The mission.
        at: Index of the instruction.
        fires: Whether a trigger of a wait may fire.
    """
    yield from successes(program, at, fires=fires)
    yield from failures(program, at)


def reached(program: Program, *, without: int | None = None) -> set[int]:
    """Return the instructions to which a way leads from the start.

    Args:
        program: The mission.
        without: A wait of which no trigger fires.
    """
    found, pending = {program.start}, [program.start]
    while pending:
        at = pending.pop()
        for target in successors(program, at, fires=at != without):
            if target >= 0 and target not in found:
                found.add(target)
                pending.append(target)
    return found


def successes(program: Program, at: int, *, fires: bool = True) -> Iterator[int]:
    """Yield where an instruction leads that does not fail; of a wait only if a trigger may fire."""
    match program.instructions[at]:
        case (
            steps.Enter() | steps.Say() | steps.Do() | steps.SwitchControl() | steps.Require()
        ) as it:
            yield it.next
        case steps.Branch() as it:
            yield from (it.if_true, it.if_false)
        case steps.Wait() as it if fires:
            yield from (each.go for each in it.triggers)
        case steps.Question() as it:
            yield from (target for _, target in it.choices)
        case steps.Wait() | steps.Raise() | steps.Finish():
            pass


def failures(program: Program, at: int) -> Iterator[int]:
    """Yield where a failure, a time limit and fault handlers lead from an instruction."""
    it = program.instructions[at]
    if isinstance(it, steps.Wait):
        yield it.within
    elif not isinstance(it, steps.Enter | steps.Say | steps.Branch | steps.Finish):
        yield it.failed
    yield from (each.go for each in program.handlers[at] if each.go is not None)
