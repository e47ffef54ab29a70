"""Check whether a mission can resume at a phase with the robot in its present state."""

from __future__ import annotations

from dataclasses import replace

from pirate_sm.checking.exploring.exploration_index import Explored, index_exploration
from pirate_sm.checking.exploring.explore import MOST_WORK, explore
from pirate_sm.checking.mission.explore_mission import conditions_of
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Do, Require
from pirate_sm.core.robot import RobotState


def why_not_from(loaded: LoadedMission, phase: str, body: RobotState) -> str:
    """Return why the mission cannot resume at the phase; empty if it can.

    Args:
        loaded: The mission.
        phase: One of its phases.
        body: The commanded state of the robot, with no array in flight.
    """
    book = _from(loaded, phase, body)
    if book is None:
        return "the mission has no such phase"
    refused = _broken(book)
    if not refused and not any(outcome == "succeeded" for outcome, _ in book.ends):
        return "from there no path leads to an end that succeeds"
    return refused


def refused_from(
    loaded: LoadedMission, phase: str, body: RobotState, most_work: float
) -> tuple[str, float]:
    """Return which command is refused, or which rule broken, from a phase on; empty if none.

    Args:
        loaded: The mission.
        phase: One of its phases.
        body: As for :func:`why_not_from`.
        most_work: The limit of the exploration; without any left nothing is found.

    Returns:
        The refusal, and the work that it has taken.
    """
    book = _from(loaded, phase, body, most_work) if most_work > 0 else None
    return (_broken(book), book.found.work) if book is not None else ("", 0.0)


def _from(
    loaded: LoadedMission, phase: str, body: RobotState, most_work: float = MOST_WORK
) -> Explored | None:
    """Return what can happen from a phase on; None if the mission does not have it."""
    begin = loaded.program.beginning(phase, body.control)
    if begin is None:
        return None
    body = body.at_rest()._replace(control=body.control)
    program = replace(loaded.program, start=begin)
    conditions = conditions_of(loaded)
    found = explore(loaded.robot, program, conditions, body=body, most_work=most_work)
    return index_exploration(found)


def _broken(book: Explored) -> str:
    return next(iter(book.broken), "") or _refused(book, book.found.program.instructions)


def _refused(book: Explored, instructions: tuple[object, ...]) -> str:
    """Return the first refusal that its step does not handle; empty without one."""
    expected = {each.place for each in instructions if isinstance(each, Do) and each.expected}
    places = {each.place for each in instructions if isinstance(each, Do | Require)}
    found = [
        (min(visits.refused), visits.name, place, visits.reasons[min(visits.refused)])
        for place, visits in book.visits.items()
        if visits.refused and place in places - expected
    ]
    if not found:
        return ""
    _, name, place, reason = min(found)
    return f"{name} ({place}) would be refused as {reason}"
