"""A rule about decisions: steps behind an `if`, and arms of a `choose`, never or always taken."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

from pirate_sm.checking.exploring.answers import Fact
from pirate_sm.checking.exploring.exploration_index import Explored
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.driving import within_reach
from pirate_sm.checking.mission.mission_view import MissionPlaces, MissionView
from pirate_sm.core.documents import Path, Place
from pirate_sm.core.expressions import Expression
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.mission import ChooseStep, Mission, every_step
from pirate_sm.core.program import Branch


def branches(view: MissionView) -> Iterator[Finding]:
    """Yield conditions in the mission's own file that have the same value wherever they are tested.

    A called mission is checked on its own, because other missions may call it too. A condition on
    states that no command has changed yet is not reported if the mission may start in other states.
    A condition that repeats what a trigger has just tested is not reported either.
    """
    seen, loaded, places = view.seen, view.loaded, view.places
    reported = set[Place]()
    for finding in _arms(view):
        reported.add(finding.place)
        yield finding
    if view.complete:
        found = _decided(seen, loaded, places)
        yield from (each for each in found if each.place not in reported)


def _decided(
    seen: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    """Yield conditions that had the same value each time they were tested."""
    truths: dict[str, set[bool]] = defaultdict(set)
    guards = set[str]()
    for book in seen:
        for where, asked in book.found.branches.items():
            for each in asked:
                truths[where].add(each.truth)
                if not each.moved:
                    guards.add(where)
    known = set(loaded.mission.starts_in or ())
    for where, condition in _conditions(loaded).items():
        place, text = places.read(where), condition.text
        if place.file != loaded.documents[0].name or len(truths[where]) != 1:
            continue
        if where in guards and not (condition.names and condition.names <= known):
            continue
        if True in truths[where]:
            message = f"'{text}' is true whenever it is asked"
            yield places.finding(place, "branch.always", message, fix="leave the condition out")
        else:
            message = f"'{text}' is never true when it is asked"
            yield places.finding(place, "branch.never", message, fix="leave the steps out")


def _conditions(loaded: LoadedMission) -> dict[str, Expression]:
    """Return the conditions of steps and choices by their places."""
    return {
        each.place: each.condition
        for each in loaded.program.instructions
        if isinstance(each, Branch)
    }


def _arms(view: MissionView) -> Iterator[Finding]:
    """Yield arms of a `choose`, and its `else`, that earlier arms make unreachable."""
    loaded, places = view.loaded, view.places
    asked, conditions = _conditions(loaded), within_reach(view)
    every = loaded.robot.table.configurations
    for step, path in _chooses(loaded.mission):
        others: list[Fact] = []
        for number in range(len(step.choose)):
            place = places.of((*path, "choose", number, "if"))
            condition = asked.get(str(place))
            if condition is None:
                break
            node = condition.tree
            own: list[Fact] = [(node, True)]
            shadowed = not conditions.anywhere([*others, *own], every)
            if others and shadowed and conditions.anywhere(own, every):
                message = f"an earlier arm is taken wherever '{condition.text}' is true"
                fix = "put it first, or leave it out"
                yield places.finding(place, "branch.never", message, fix=fix)
            others.append((node, False))
        else:
            if step.otherwise and len(others) > 1 and not conditions.anywhere(others, every):
                message = "one of the arms is always taken: nothing is left for `else`"
                place = places.of((*path, "else"))
                yield places.finding(place, "branch.never", message)


def _chooses(mission: Mission) -> Iterator[tuple[ChooseStep, Path]]:
    """Yield every `choose` of a mission with its path."""
    for name, phase in mission.phases.items():
        for step, path in every_step(phase.do, ("phases", name, "do")):
            if isinstance(step, ChooseStep):
                yield step, path
