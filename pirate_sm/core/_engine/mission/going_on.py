"""Move the mission to another instruction, also after a failure."""

from __future__ import annotations

from pirate_sm.core._engine.mission.ending import end, withdraw
from pirate_sm.core._engine.mission.program import STOP
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.state import EngineState, MissionState


def fail(moment: Moment, state: EngineState, cause: str, target: int) -> EngineState:
    """Continue at the failure's target; without a handler end the mission as failed (rule 4).

    A failure that the mission ignores does not replace the cause of an earlier one.
    """
    passed_over = target == getattr(moment.program.instructions[state.mission.pc], "next", STOP)
    kept = state.mission.cause if passed_over else ""
    mission = state.mission._replace(cause=kept or cause)
    if target == STOP:
        state = state._replace(mission=mission)
        return end(moment, state, "failed", cause)
    withdraw(moment, state)
    moment.warn(cause)
    return state._replace(mission=moved(mission, target))


def moved(mission: MissionState, target: int) -> MissionState:
    """Return the mission at another instruction; a single step ends there with a pause."""
    mission = mission.at(target)
    if mission.one_step:
        return mission._replace(one_step=False, pause_wanted=True)
    return mission


def go(state: EngineState, target: int) -> EngineState:
    """Return the state with the mission at another instruction."""
    return state._replace(mission=moved(state.mission, target))
