"""Compute a robot's largest speed, and the phases before which it has driven."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import inf
from typing import TypeVar

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.exploration import Exploration
from pirate_sm.checking.exploring.signal_ranges import Range
from pirate_sm.checking.mission.mission_view import MissionView
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Wait

T = TypeVar("T")


def within_reach(view: MissionView) -> Conditions:
    """Return the conditions for a robot limited by the no-load speed of its motors."""
    robot, most = view.loaded.robot, fastest_m_s(view.loaded)
    if robot.speed < 0:
        return view.conditions
    return view.conditions.within({robot.vocabulary.numbers[robot.speed]: Range(-most, most)})


def fastest_m_s(loaded: LoadedMission) -> float:
    """Return the no-load speed of the fastest wheel, m/s; infinite if unknown."""
    profile = loaded.loaded_robot.profile
    rates = [
        profile.motors[slot.motor].no_load_speed
        for board in profile.boards
        for slot in board.slots
        if slot.wheel is not None
    ]
    known = [each for each in rates if each is not None]
    return max(known) * profile.body.wheel_radius if known and len(known) == len(rates) else inf


def driven_before(
    found: Exploration, driven: Sequence[Collection[int]]
) -> Iterator[tuple[int, str]]:
    """Yield each node after a wait in which the robot has driven, with the place of the wait.

    Args:
        found: The exploration.
        driven: Per configuration the regions that drive wheels.
    """
    for step in found.steps:
        if step.source < 0:
            continue
        before = found.nodes[step.source].state
        it = found.program.instructions[before.mission.pc]
        left = found.nodes[step.target].state.mission.pc != before.mission.pc
        drives = before.mission.begun and driven[before.robot.configuration]
        if isinstance(it, Wait) and left and drives:
            yield step.target, it.place


def led_to(found: Exploration, begun: Iterable[tuple[int, T]]) -> Mapping[str, set[T]]:
    """Return for each phase what has begun in it, or in nodes that can lead to it.

    Of more than two things at least two are returned: enough to know whether one is not alone.

    Args:
        found: The exploration.
        begun: Nodes, each with what begins there.
    """
    after, known = defaultdict[int, list[int]](list), defaultdict[int, set[T]](set)
    for step in found.steps:
        after[step.source].append(step.target)
    waiting, phases = list(begun), defaultdict[str, set[T]](set)
    while waiting:
        node, what = waiting.pop()
        here = known[node]
        if what not in here and len(here) < 2:
            here.add(what)
            phases[found.program.phase_of[found.nodes[node].state.mission.pc]].add(what)
            waiting += [(each, what) for each in after[node]]
    return phases
