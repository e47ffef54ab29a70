"""Explore what can happen to a mission that resumes after a crash, before anybody agrees to it."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from typing import Literal, NamedTuple

from pirate_sm.checking.exploring.exploration import Exploration, Explored, index_exploration, story
from pirate_sm.checking.exploring.explore import conditions_of, explore
from pirate_sm.checking.mission.reachability import cannot_end
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Program
from pirate_sm.core.resuming import Resumption
from pirate_sm.core.robot import Mark, declared_states

Word = Literal["possible", "may hang", "fails", "impossible", "not explored"]


class Forecast(NamedTuple):
    """What can become of a mission that resumes.

    Attributes:
        word: ``possible``: an end that succeeds can be reached, and nothing stands in the way.
            ``may hang``: it can, but a wait may end by its time limit only, or not at all.
            ``fails``: it can only come to ends that fail. ``impossible``: it cannot resume.
            ``not explored``: there are too many possibilities.
        why: Why it is not simply possible; else empty.
        course: An event sequence that shows it, one sentence for each.
    """

    word: Word
    why: str = ""
    course: tuple[str, ...] = ()


def forecast(
    loaded: LoadedMission, it: Resumption, confirmed: AbstractSet[Mark] = frozenset()
) -> Forecast:
    """Return what can become of the mission.

    Args:
        loaded: The mission as recorded; its program is that of the run before.
        it: What it resumes with.
        confirmed: The marks of the resumption's robot that the sensors have confirmed.
    """
    body = it.body._replace(marks=it.body.marks - confirmed)
    body = body._replace(marks=body.marks - declared_states.awaiting(loaded.robot, body))
    program = it.program(loaded.program)
    found = explore(loaded.robot, program, conditions_of(loaded), body=body)
    book = index_exploration(found)
    if book.broken:
        message, step = next(iter(book.broken.items()))
        return Forecast("impossible", message, story(found, step))
    good = [step for (outcome, _), step in book.ends.items() if outcome == "succeeded"]
    if not good and not found.complete:
        return Forecast("not explored", "there are too many possibilities")
    if not good:
        return Forecast("fails", "no path leads to an end that succeeds", _failing(book))
    return _hanging(loaded, it, program, found) or Forecast("possible")


def _failing(book: Explored) -> tuple[str, ...]:
    """Return the course to an end that has the fewest mishaps."""
    steps = sorted(book.ends.values(), key=lambda step: (book.found.mishaps(step), step))
    return story(book.found, steps[0]) if steps else ()


def _hanging(
    loaded: LoadedMission, it: Resumption, program: Program, found: Exploration
) -> Forecast | None:
    """Return the forecast if the mission may hang; else None."""
    read = dict(it.positions_read(loaded.robot, program))
    for node in found.nodes:
        mission = node.state.mission
        if mission.begun and mission.pc in read:
            why = f"it waits for a position ({read[mission.pc]}), and its position is unknown"
            return Forecast("may hang", why, story(found, node.step))
    lost = cannot_end(found) if found.complete else set()
    if not lost:
        return None
    first = found.nodes[min(lost)]
    why = f"from {program.phase_of[first.state.mission.pc]} no end that succeeds may be reached"
    return Forecast("may hang", why, story(found, first.step))
