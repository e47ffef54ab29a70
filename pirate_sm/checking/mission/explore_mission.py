"""Explore a mission as it is, and with its faults corrected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.exploration_index import Explored, index_exploration
from pirate_sm.checking.exploring.explore import MOST_WORK, explore
from pirate_sm.checking.exploring.signal_ranges import ranges
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Do, Program, Raise, Require, Say

MOST_ASSUMPTIONS = 20
"""How often the exploration is repeated without steps that can never run."""


def conditions_of(loaded: LoadedMission) -> Conditions:
    """Return the decision procedure for conditions on the mission's robot."""
    spans = ranges(loaded.loaded_robot.profile, loaded.robot)
    return Conditions(loaded.robot.vocabulary.with_changes, spans, len(loaded.robot.regions))


def explore_mission(loaded: LoadedMission, conditions: Conditions) -> list[Explored]:
    """Explore a mission repeatedly, each time without the steps that can never run.

    After a certain refusal the check continues without the step, to find later faults as well. All
    explorations together are limited to the work of one.
    """
    program = loaded.program
    explored: list[Explored] = []
    left: float = MOST_WORK
    for _ in range(MOST_ASSUMPTIONS):
        book = index_exploration(explore(loaded.robot, program, conditions, most_work=left))
        left -= book.found.work
        known = {place for earlier in explored for place in earlier.visits}
        explored.append(book)
        stuck = {
            place
            for place, visits in book.visits.items()
            if place not in known and visits.never_fine
        }
        if not stuck or not book.found.complete:
            break
        program = _without(program, stuck)
    return explored


def _without(program: Program, places: set[str]) -> Program:
    """Return the program without the steps or calls at these places."""
    instructions = tuple(
        Require((), "", _after(program, index), each.failed, "")
        if isinstance(each, Do | Require) and each.place in places
        else each
        for index, each in enumerate(program.instructions)
    )
    return replace(program, instructions=instructions)


def _after(program: Program, index: int) -> int:
    """Return the instruction after a step; after a call, the target of its success."""
    step = program.instructions[index]
    assert isinstance(step, Do | Require)
    if isinstance(step, Do):
        return step.next
    for end in program.instructions[index + 1 :]:
        if isinstance(end, Say):
            return end.next
        if not isinstance(end, Raise):
            break
    return step.next  # it has no end that succeeds


def explore_corrected(
    explored: Sequence[Explored], loaded: LoadedMission, conditions: Conditions
) -> list[Explored]:
    """Explore a mission whose refused steps and broken rules have been corrected.

    Parts that are reached, needed or fired only then are not reported as never reached, needed or
    fired.
    """
    last = explored[-1]
    refused = {
        place for book in explored for place, visits in book.visits.items() if visits.refused
    }
    broken = any(book.broken for book in explored)
    if not last.found.complete or not (refused or broken):
        return []
    program = last.found.program
    instructions = tuple(
        each._replace(failed=_after(program, index))
        if isinstance(each, Do | Require) and each.place in refused
        else each
        for index, each in enumerate(program.instructions)
    )
    corrected = replace(program, instructions=instructions, rules=() if broken else program.rules)
    left = MOST_WORK - sum(book.found.work for book in explored)
    return [index_exploration(explore(loaded.robot, corrected, conditions, most_work=left))]
