"""The waits that a hand-back at a later phase would skip.

The operator is shown them, because a mission checks the world in its waits, while a hand-back
checks only the robot's states.
"""

from __future__ import annotations

from collections.abc import Container

from pirate_sm.engine.mission.program import Program, Wait
from pirate_sm.engine.mission.successors import reached


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
    goal = program.enter(phase)
    if goal is None or goal not in reached(program):
        return ()
    return tuple(
        each
        for at, each in enumerate(program.instructions)
        if isinstance(each, Wait) and goal not in reached(program, without=at)
    )
