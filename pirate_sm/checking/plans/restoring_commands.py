"""Find the commands that restore a configuration in which a phase can begin."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from pirate_sm.checking.exploring.explore import explore
from pirate_sm.checking.mission.explore_mission import conditions_of
from pirate_sm.checking.plans.phase_entry import why_not_from
from pirate_sm.core.effects import PhaseChange
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.robot import Plan, RobotState, RulePlaces, at_rest_in, plans

Beginnings = Mapping[str, frozenset[int]]
"""For each phase the configurations in which a mission run from its start enters it."""


def beginnings(loaded: LoadedMission) -> Beginnings:
    """Explore the mission and return the configurations in which each phase begins.

    It begins as its file says, also where the robot was adopted elsewhere.
    """
    found: dict[str, set[int]] = {}
    table, wanted = loaded.robot.table, loaded.mission.starts_in or {}
    initial = zip(table.regions, table.configurations[table.initial], strict=True)
    at_start = table.index_of(tuple(wanted.get(region, state) for region, state in initial))
    program = loaded.program
    if at_start is not None:
        program = replace(program, start_configuration=at_start)
    exploration = explore(loaded.robot, program, conditions_of(loaded))
    for step in exploration.steps:
        for effect in step.effects:
            if isinstance(effect, PhaseChange):
                body = exploration.nodes[step.target].state.robot
                found.setdefault(effect.phase, set()).add(body.configuration)
    return {phase: frozenset(configurations) for phase, configurations in found.items()}


def restoring(
    loaded: LoadedMission,
    phases: Collection[str],
    body: RobotState,
    begun_in: Beginnings,
    places: RulePlaces | None = None,
) -> dict[str, Plan]:
    """Return for each phase the best plan after which the mission can resume there.

    A plan ends in a configuration in which the mission enters the phase by itself, and from which
    :func:`why_not_from` finds no obstacle. Phases that no commands reach are left out. A plan with
    a hindrance explains the obstacle and must not be executed.

    Args:
        loaded: The mission.
        phases: The phases to examine.
        body: The commanded state of the robot, with no array in flight.
        begun_in: The result of :func:`beginnings`.
        places: Progress of the mission's safety rules; None if they are not evaluated yet.
    """
    body = body.at_rest()._replace(control=body.control)
    missing = {phase: begun_in[phase] for phase in phases if begun_in.get(phase)}
    hopeless = {phase for phase in missing if _never(loaded, phase, missing[phase])}
    found: dict[str, Plan] = {}
    for plan in plans(loaded.robot, loaded.program, body, places):
        for phase, configurations in missing.items():
            if phase in found or phase in hopeless or plan.body.configuration not in configurations:
                continue
            if not why_not_from(loaded, phase, plan.body):
                found[phase] = plan
        if len(found) + len(hopeless) == len(missing):
            break
    return found


def _never(loaded: LoadedMission, phase: str, configurations: Collection[int]) -> bool:
    """Return whether the phase cannot succeed even in the configurations in which it begins."""
    return all(
        why_not_from(loaded, phase, at_rest_in(loaded.robot, each)) for each in configurations
    )
