"""Compute a robot's largest speed, and the phases before which it has driven."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.exploration import Exploration
from pirate_sm.checking.exploring.signal_ranges import Range, ranges
from pirate_sm.engine.mission.program import Wait
from pirate_sm.loading.mission import LoadedMission


def within_reach(loaded: LoadedMission) -> Conditions:
    """Return the conditions for a robot limited by the no-load speed of its motors."""
    robot, most = loaded.robot, fastest_m_s(loaded)
    spans = dict(ranges(loaded.loaded_robot.profile, robot))
    if robot.speed >= 0:
        spans[robot.vocabulary.numbers[robot.speed]] = Range(-most, most)
    return Conditions(robot.vocabulary.with_changes, spans, len(robot.regions))


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
    found: Exploration, loaded: LoadedMission, apart: Wait | None = None
) -> frozenset[str]:
    """Return the phases whose wait may begin after the robot has driven in an earlier wait.

    Args:
        found: The exploration.
        loaded: The mission.
        apart: A wait that does not count.
    """
    instructions, driven = found.program.instructions, loaded.robot.driven
    begin = []
    for step in found.steps:
        if step.source < 0:
            continue
        before = found.nodes[step.source].state
        it = instructions[before.mission.pc]
        counts = isinstance(it, Wait) and (apart is None or it.place != apart.place)
        left = found.nodes[step.target].state.mission.pc != before.mission.pc
        if counts and before.mission.begun and left and driven[before.robot.configuration]:
            begin.append(step.target)
    return phases_after(found, begin)


def phases_after(found: Exploration, begin: list[int]) -> frozenset[str]:
    """Return the phases to which some states can lead, and their own."""
    after: dict[int, list[int]] = {}
    for step in found.steps:
        after.setdefault(step.source, []).append(step.target)
    reached = _reached(begin, after)
    return frozenset(found.program.phase_of[found.nodes[n].state.mission.pc] for n in reached)


def _reached(begin: list[int], after: Mapping[int, Sequence[int]]) -> set[int]:
    """Return the nodes that any way leads to from those at the beginning, and these."""
    reached, waiting = set(begin), list(begin)
    while waiting:
        for target in after.get(waiting.pop(), ()):
            if target not in reached:
                reached.add(target)
                waiting.append(target)
    return reached
