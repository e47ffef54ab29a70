"""Signals from a script instead of sensors, in runs where commands take their nominal time."""

from __future__ import annotations

from math import nan

from pirate_sm.core._engine.control.torque_loop import RunningTorqueLoop
from pirate_sm.core._engine.mission.program import Program, SwitchControl
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import commands
from pirate_sm.core._engine.robot.robot_state import Finished
from pirate_sm.core._engine.state import OUTSIDE, EngineState
from pirate_sm.core._model.events import CommandFailed, SignalReport


def show(moment: Moment, state: EngineState, report: SignalReport) -> EngineState:
    """Set the signals that conditions see to those of the script; refuse that on real sensors."""
    if not moment.nominal:
        moment.warn("a script cannot replace the signals of real sensors")
        return state
    names = moment.robot.vocabulary.with_changes.numbers
    sensing = state.sensing
    numbers = list(sensing.told or sensing.numbers)
    if any(name.startswith("change(") for name, _ in report.numbers):
        numbers += [nan] * (len(names) - len(numbers))
    for name, value in report.numbers:
        if name in names:
            numbers[names.index(name)] = value
        else:
            moment.warn(f"the script says '{name}', an unknown signal")
    for name, word in report.words:
        if name in OUTSIDE:
            state = state.hearing(**{name: word})
        else:
            moment.warn(f"the script says '{name}', which no script can set")
    return state._replace(sensing=sensing._replace(told=tuple(numbers)))


def fail_command(moment: Moment, state: EngineState, event: CommandFailed) -> EngineState:
    """Let the command under way fail as by its timeout, unless its array is still in flight.

    A switch of the control fails once its array is accepted, since it is done then on paper.
    """
    body = state.robot
    if moment.nominal and awaits_torques(moment.program, state):
        mission = state.mission._replace(result=Finished(False, event.reason))
        return state._replace(mission=mission)
    if not moment.nominal or body.motion is None or body.awaited is not None:
        moment.warn("no command is under way that a script could let fail")
        return state
    body = commands.fail(moment, body, event.reason)
    mission = state.mission._replace(result=Finished(False, event.reason))
    return state._replace(robot=body, mission=mission)


def awaits_torques(program: Program, state: EngineState) -> bool:
    """Whether the mission switches its control and that can fail: a joint shall bear a torque."""
    mission, body = state.mission, state.robot
    return (
        mission.begun
        and mission.result is None
        and isinstance(program.instructions[mission.pc], SwitchControl)
        and any(isinstance(each, RunningTorqueLoop) for each in body.loops)
    )
