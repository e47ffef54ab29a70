"""What follows from a fault: it is logged, or leads elsewhere, or ends the mission (rule 10)."""

from __future__ import annotations

from pirate_sm.engine.mission import pausing
from pirate_sm.engine.mission.ending import end, withdraw
from pirate_sm.engine.robot import commands, robot_state
from pirate_sm.engine.safety.faults import Found
from pirate_sm.engine.state import EngineState, Setting
from pirate_sm.model.effects import Effect, Fault


def meet(
    setting: Setting, state: EngineState, fault: Found, now: float, effects: list[Effect]
) -> EngineState:
    """The fault is handled as the mission says, or the mission ends."""
    mission = state.mission
    if mission.ended:
        return state
    if fault.denies:
        state = state._replace(
            robot=commands.deny(setting.robot, state.robot, fault.denies, effects)
        )
    if mission.ending:
        effects.append(Fault(fault.code, fault.message, "stop"))
        return state
    handler = setting.program.handler(mission.pc, fault.code) if fault.catchable else None
    cause = f"{fault.code}: {fault.message}"
    if handler is not None and handler.go is None:
        effects.append(Fault(fault.code, fault.message, "continue"))
        return state
    if handler is None or mission.handling or mission.diverting:
        effects.append(Fault(fault.code, fault.message, "stop"))
        return end(setting, state, "fault", cause, "", now, effects)
    effects.append(Fault(fault.code, fault.message, handler.go_name))
    mission = mission._replace(diverting=handler, stopped=False, cause=cause)
    return state._replace(mission=mission)


def divert(setting: Setting, state: EngineState, now: float, effects: list[Effect]) -> EngineState:
    """Once the array in flight is resolved and the wheels are stopped, the handler begins."""
    mission, robot = state.mission, state.robot
    handler = mission.diverting
    if handler is None or handler.go is None or robot.flight is not None:
        return state
    if not mission.stopped:
        withdraw(setting, state, effects)
        if robot.motion is not None:
            reason = f"interrupted by {mission.cause}"
            robot = commands.fail(setting.robot, robot, reason, effects)
        robot = commands.doubt(setting.robot, robot)
        effects.append(robot_state.state_change(setting.robot, robot))
        robot = commands.stop(setting.robot, robot, state.sensing, effects)
        mission = mission._replace(stopped=True, begun=False)
        return state._replace(robot=robot, mission=mission)
    mission = pausing.forget(mission, robot).at(handler.go)
    return state._replace(
        mission=mission._replace(diverting=None, stopped=False, handling=handler.go_name)
    )
