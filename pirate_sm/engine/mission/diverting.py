"""What follows from a fault: it is logged, or leads elsewhere, or ends the mission (rule 10)."""

from __future__ import annotations

from pirate_sm.engine.mission import pausing
from pirate_sm.engine.mission.ending import end, withdraw
from pirate_sm.engine.moment import Moment
from pirate_sm.engine.robot import commands, robot_state
from pirate_sm.engine.safety.faults import Found
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Fault


def meet(moment: Moment, state: EngineState, fault: Found) -> EngineState:
    """The fault is handled as the mission says, or the mission ends."""
    mission = state.mission
    if mission.ended:
        return state
    if fault.denies:
        state = state._replace(robot=commands.deny(moment, state.robot, fault.denies))
    if mission.ending:
        moment.tell(Fault(fault.code, fault.message, "stop"))
        return state
    handler = moment.program.handler(mission.pc, fault.code) if fault.catchable else None
    cause = f"{fault.code}: {fault.message}"
    if handler is not None and handler.go is None:
        moment.tell(Fault(fault.code, fault.message, "continue"))
        return state
    if handler is None or mission.handling or mission.diverting:
        moment.tell(Fault(fault.code, fault.message, "stop"))
        return end(moment, state, "fault", cause, "")
    moment.tell(Fault(fault.code, fault.message, handler.go_name))
    mission = mission._replace(diverting=handler, stopped=False, cause=cause)
    return state._replace(mission=mission)


def divert(moment: Moment, state: EngineState) -> EngineState:
    """Once the array in flight is resolved and the wheels are stopped, the handler begins."""
    mission, robot = state.mission, state.robot
    handler = mission.diverting
    if handler is None or handler.go is None or robot.flight is not None:
        return state
    if not mission.stopped:
        withdraw(moment, state)
        if robot.motion is not None:
            reason = f"interrupted by {mission.cause}"
            robot = commands.fail(moment, robot, reason)
        robot = commands.doubt(moment.robot, robot)
        moment.tell(robot_state.state_change(moment.robot, robot))
        robot = commands.stop(moment, robot, state.sensing)
        mission = mission._replace(stopped=True, begun=False)
        return state._replace(robot=robot, mission=mission)
    mission = pausing.forget(mission, robot).at(handler.go)
    return state._replace(
        mission=mission._replace(diverting=None, stopped=False, handling=handler.go_name)
    )
