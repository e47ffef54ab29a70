"""The waits that a hand-back at a later phase would skip.

The operator is shown them, because a mission checks the world in its waits, while a hand-back
checks only the robot's states.
"""

from __future__ import annotations

from collections.abc import Container, Iterator

from pirate_sm.engine.mission import program as steps
from pirate_sm.engine.mission.program import Program, Wait


def not_passed(program: Program, phase: str, passed: Container[str]) -> str:
    """Return the waits before the phase that have not been passed, in words; empty if none.

    Args:
        program: The mission.
        phase: One of its phases.
        passed: Places of the passed waits.
    """
    left = [each.phase for each in waits_before(program, phase) if each.place not in passed]
    phases = list(dict.fromkeys(left))
    return f"its wait{'s' if len(left) > 1 else ''} of {', '.join(phases)}" if phases else ""


def waits_before(program: Program, phase: str) -> tuple[Wait, ...]:
    """Return the waits of which a trigger must fire on every way from the start to the phase.

    Failures, faults and time limits are ways too: a phase that they can reach from anywhere has
    no waits before it.
    """
    goal = program.beginning(phase)
    if goal is None or goal not in _reached(program):
        return ()
    return tuple(
        each
        for at, each in enumerate(program.instructions)
        if isinstance(each, Wait) and goal not in _reached(program, without=at)
    )


def _reached(program: Program, without: int | None = None) -> set[int]:
    """Return the instructions that are reachable if no trigger of the wait ``without`` fires."""
    found = {program.start}
    left = [program.start]
    while left:
        at = left.pop()
        for after in _ways(program, at, fires=at != without):
            if after >= 0 and after not in found:
                found.add(after)
                left.append(after)
    return found


def _ways(program: Program, at: int, *, fires: bool) -> Iterator[int]:
    """Yield the successors of an instruction; ``fires``: whether a trigger of a wait fires."""
    yield from (each.go for each in program.handlers[at] if each.go is not None)
    match program.instructions[at]:
        case steps.Enter() | steps.Say() as it:
            yield it.next
        case steps.Do() | steps.Require() as it:
            yield from (it.next, it.failed)
        case steps.Branch() as it:
            yield from (it.if_true, it.if_false)
        case steps.Wait() as it:
            yield it.within
            if fires:
                yield from (each.go for each in it.triggers)
        case steps.Question() as it:
            yield from (*(target for _, target in it.choices), it.failed)
        case steps.Raise() as it:
            yield it.failed
        case steps.Finish():
            pass
