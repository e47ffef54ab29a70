"""What a mission that is handed back at a later phase leaps over: the waits that it has not passed.

The operator is shown them, because a wait is where a mission looks at the world, and a hand-back
looks at the robot's states alone.
"""

from __future__ import annotations

from collections.abc import Container, Iterator

from pirate_sm.engine.mission import program as steps
from pirate_sm.engine.mission.program import Program, Wait


def not_passed(program: Program, phase: str, passed: Container[str]) -> str:
    """Return the waits before the phase that have not been passed, in words; empty: there are none.

    Args:
        program: The mission.
        phase: One of its phases.
        passed: Places of the waits that have been passed.
    """
    left = [each.phase for each in waits_before(program, phase) if each.place not in passed]
    phases = list(dict.fromkeys(left))
    return f"its wait{'s' if len(left) > 1 else ''} of {', '.join(phases)}" if phases else ""


def waits_before(program: Program, phase: str) -> tuple[Wait, ...]:
    """Return the waits of which a trigger must fire on every way from the start to the phase.

    Failures, faults and time limits are ways too: a phase to which they lead from anywhere has
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
    """The instructions that can come when no trigger of the wait at ``without`` fires."""
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
    """Where an instruction leads; ``fires``: whether a trigger of a wait does."""
    yield from (each.go for each in program.handlers[at] if each.go is not None)
    match program.instructions[at]:
        case steps.Enter() | steps.Say() as it:
            yield it.next
        case steps.Do() | steps.SwitchControl() | steps.Require() as it:
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
