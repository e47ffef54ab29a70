"""In which situations each phase of a mission can begin: where it can be handed back."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace

from pirate_sm.checking.exploring.ledger import Ledger
from pirate_sm.checking.mission import MissionCheck, check_loaded
from pirate_sm.engine.program import Situation
from pirate_sm.engine.robot_state import situation
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model.effects import PhaseChange


def entries_of(book: Ledger) -> Mapping[str, frozenset[Situation]]:
    """Per phase every situation in which the exploration has seen it begin."""
    found: dict[str, set[Situation]] = defaultdict(set)
    robot = book.found.robot
    for step in book.found.steps:
        for effect in step.effects:
            if isinstance(effect, PhaseChange):
                body = book.found.nodes[step.target].state.robot
                found[effect.phase].add(situation(robot, body))
    return {phase: frozenset(situations) for phase, situations in found.items()}


def with_entries(loaded: LoadedMission, check: MissionCheck | None = None) -> LoadedMission:
    """The same mission, which can be handed back at its phases.

    Args:
        loaded: The mission.
        check: What a check of it has found, where that has been done.
    """
    explored = (check or check_loaded(loaded)).explored
    entries = entries_of(explored[0]) if explored else {}
    return replace(loaded, program=replace(loaded.program, entries=entries))
