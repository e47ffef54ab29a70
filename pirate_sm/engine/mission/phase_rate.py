"""Limit how many phases begin within a second of mission time."""

from __future__ import annotations

from pirate_sm.engine.mission.program import Program
from pirate_sm.engine.state import MissionState
from pirate_sm.model.fault_codes import BuiltInFault

RUNAWAY = BuiltInFault.MISSION_RUNAWAY.code
"""The fault of a mission whose phases follow each other faster than sensors report."""

MOST_TURNS = 4
"""How often one instruction may be reached at the same time. It is reached again only after an
answer of the operator or at the end of a fault's handling; more often means an endless loop."""


def counted(mission: MissionState, clock: float) -> MissionState:
    """Return the mission with one more phase counted."""
    if clock >= mission.second_s + 1.0:
        return mission._replace(second_s=clock, entered=1)
    return mission._replace(entered=mission.entered + 1)


def too_fast(program: Program, mission: MissionState) -> str:
    """Return why the mission must end; empty while it may continue.

    The limit grows with the length of the mission. Phases that repeat without any time passing
    are reported separately.
    """
    most = max(program.most_phases, MOST_TURNS * len(program.instructions))
    if mission.entered <= most:
        return ""
    return f"more than {most:g} phases have begun within a second"
