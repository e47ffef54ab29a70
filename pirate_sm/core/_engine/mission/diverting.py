"""Handle a fault: log it, go to its handler, or end the mission (rule 10)."""

from __future__ import annotations

from collections.abc import Iterable

from pirate_sm.core._engine.mission import pausing
from pirate_sm.core._engine.mission.ending import end_by_fault, withdraw
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import commands, robot_state
from pirate_sm.core._engine.robot.unmet_conditions import unmet_conditions
from pirate_sm.core._engine.safety.faults import FoundFault
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._model.effects import Fault
from pirate_sm.core._model.events import EVIDENCE_ENDS
from pirate_sm.core._model.fault_codes import UNSEEN
from pirate_sm.core._model.unmet_words import with_unmet


def meet(moment: Moment, state: EngineState, fault: FoundFault) -> EngineState:
    """Log the fault and start its handler in the mission, or end the mission without one."""
    mission = state.mission
    if mission.ended:
        return state
    if moment.alphabet < EVIDENCE_ENDS:
        fault = fault._replace(of=())
    if fault.denies:
        state = state._replace(robot=commands.deny(moment, state.robot, fault.denies))
    if fault.code in UNSEEN:
        state = lapse(moment, state, fault.of)
    if mission.ending:
        moment.emit(Fault(fault.code, fault.message, "stop", fault.of))
        return state
    things = moment.robot.owners.things_of(fault.of)
    handler = moment.program.handler(mission.pc, fault.code, things) if fault.catchable else None
    cause = f"{fault.code}: {fault.message}"
    if handler is not None and handler.go is None:
        moment.emit(Fault(fault.code, fault.message, "continue", fault.of))
        return state
    if handler is None or mission.handling or mission.diverting:
        return end_by_fault(moment, state, fault.code, fault.message, fault.of)
    moment.emit(Fault(fault.code, fault.message, handler.go_name, fault.of))
    mission = mission._replace(diverting=handler, stopped=False, cause=cause)
    return state._replace(mission=mission)


def lapse(moment: Moment, state: EngineState, of: Iterable[str]) -> EngineState:
    """Take back that parts hold of which nothing is measured any more that shows it.

    Args:
        moment: The time, the robot and the effects so far.
        state: The state.
        of: Names of the boards, joints and wheels that are not measured.
    """
    if moment.nominal or moment.alphabet < EVIDENCE_ENDS:
        return state
    parts = moment.robot.unproved(of)
    body = commands.deny(moment, state.robot, parts, robot_state.LAPSED)
    return state._replace(robot=body) if body is not state.robot else state


def lapse_unheard(moment: Moment, state: EngineState) -> EngineState:
    """Do so for the boards whose signals are too old, before a command is judged."""
    stale, boards = state.sensing.stale, moment.robot.boards.values()
    if not stale:
        return state
    return lapse(moment, state, (each.name for each in boards if each.position in stale))


def divert(moment: Moment, state: EngineState) -> EngineState:
    """Stop the wheels as soon as no array is awaited, then start the fault's handler."""
    mission, robot = state.mission, state.robot
    handler = mission.diverting
    if handler is None or handler.go is None or robot.awaited is not None:
        return state
    if not mission.stopped:
        withdraw(moment, state)
        if robot.motion is not None:
            reason = f"interrupted by {mission.cause}"
            unmet = unmet_conditions(moment, robot, state.sensing)
            robot = commands.fail(moment, robot, with_unmet(reason, unmet), unmet)
        robot = commands.doubt(moment.robot, robot)
        moment.emit(robot_state.state_change(moment.robot, robot))
        robot = commands.stop(moment, robot, state.sensing)
        mission = mission._replace(stopped=True, begun=False)
        return state._replace(robot=robot, mission=mission)
    if state.look is not None:
        return state
    mission = pausing.forget(mission, robot).at(handler.go)
    return state._replace(
        mission=mission._replace(diverting=None, stopped=False, handling=handler.go_name)
    )
