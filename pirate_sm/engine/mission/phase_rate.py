"""Limit how many phases begin within a second of mission time."""

from __future__ import annotations

from pirate_sm.engine.mission.program import Program
from pirate_sm.engine.state import MissionState
from pirate_sm.model.fault_codes import BuiltInFault

RUNAWAY = BuiltInFault.MISSION_RUNAWAY.code
"""The fault of a mission whose phases follow each other faster than sensors can speak."""

MOST_TURNS = 4
"""In one moment an instruction's turn comes again at most where the operator's word has been heard
in between, or the handling of a fault is over. One that comes more often comes for ever."""


def counted(mission: MissionState, clock: float) -> MissionState:
    """Return the mission with one more phase begun."""
    if clock >= mission.second_s + 1.0:
        return mission._replace(second_s=clock, entered=1)
    return mission._replace(entered=mission.entered + 1)


def too_fast(program: Program, mission: MissionState) -> str:
    """Return why the mission may not go on; empty while it may.

    A long mission may begin more phases: those that go round at one moment are reported as that.
    """
    most = max(program.most_phases, MOST_TURNS * len(program.instructions))
    if mission.entered <= most:
        return ""
    return f"more than {most:g} phases have begun within a second"
