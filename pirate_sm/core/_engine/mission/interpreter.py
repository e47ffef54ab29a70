"""Execute the mission's instructions, one function per kind (rules: docs/missions.md)."""

from __future__ import annotations

from typing import assert_never

from pirate_sm.core._engine import safety
from pirate_sm.core._engine.mission import flow
from pirate_sm.core._engine.mission.flow import end, end_by_fault, fail, go, lapse_unheard
from pirate_sm.core._engine.mission.program import (
    Branch,
    Do,
    Enter,
    Finish,
    Instruction,
    Program,
    Question,
    Raise,
    Require,
    Say,
    SwitchControl,
    Wait,
)
from pirate_sm.core._engine.mission.waiting import met_unknown, question, wait, with_measured
from pirate_sm.core._engine.moment import Moment, has_come
from pirate_sm.core._engine.robot import command_outcome, commands, declared_states, robot_state
from pirate_sm.core._engine.robot.robot_state import RobotState
from pirate_sm.core._engine.robot.setpoint_arrays import unsettled
from pirate_sm.core._engine.state import EngineState, MissionState
from pirate_sm.core._model.faults import BuiltInFault
from pirate_sm.core.effects import CommandStatus, Log, PhaseChange

ROUND_AND_ROUND = "the phases repeat without ever waiting"


def advance(moment: Moment, state: EngineState) -> EngineState:
    """Execute instructions until one must wait.

    Once its time is up nothing is commanded any more; what else is due now comes before (rule 6).
    """
    instructions = moment.program.instructions
    for _ in range(MOST_TURNS * len(instructions)):
        mission = state.mission
        if mission.ending or mission.ended:
            return state
        if mission.diverting or mission.paused or mission.pause_wanted:
            return state
        instruction = instructions[mission.pc]
        begins = isinstance(instruction, Do | SwitchControl) and not mission.begun
        if begins and has_come(mission.clock(moment.now_s), moment.program.time_limit_s):
            return state
        if (mission.breakpoints or mission.until) and _breaks(mission, instruction):
            return flow.pause_at(moment, state, instruction.place)
        after = _execute(moment, state, instruction)
        if after.mission.pc == mission.pc and after.mission.begun:
            return after
        if after is state:
            return state
        state = after
    return end(moment, state, "failed", ROUND_AND_ROUND)


def _breaks(mission: MissionState, it: Instruction) -> bool:
    """Return whether the mission must pause before this instruction, which has not begun.

    A command that is repeated after a failure has begun.
    """
    if mission.begun or mission.tries or mission.passes or not it.place:
        return False
    return it.place in mission.breakpoints or it.place == mission.until


def _execute(  # noqa: C901 - one case for each kind of instruction
    moment: Moment, state: EngineState, it: Instruction
) -> EngineState:
    match it:
        case Wait():
            return wait(moment, state, it)
        case Do():
            return _do(moment, state, it)
        case SwitchControl():
            return _switch_control(moment, state, it)
        case Enter():
            return _enter(moment, state, it)
        case Branch():
            return _branch(moment, state, it)
        case Require():
            return _require(moment, state, it)
        case Question():
            return question(moment, state, it)
        case Say():
            return _say(moment, state, it)
        case Raise():
            return _raise(moment, state, it)
        case Finish():
            return _finish(moment, state, it)
        case _:
            assert_never(it)


def without_requests(moment: Moment, state: EngineState) -> MissionState:
    """Return the mission without the operator's answer and skip, which have been processed.

    A skip is kept while an array of the step is in flight: whether that has moved the chart, or is
    in force, is not known before.
    """
    mission, it = state.mission, moment.program.instructions[state.mission.pc]
    doing = mission.begun and isinstance(it, Do | SwitchControl)
    waits = doing and state.robot.awaited is not None
    return mission._replace(answer=None, skipped=mission.skipped if waits else None)


def _enter(moment: Moment, state: EngineState, it: Enter) -> EngineState:
    moment.emit(PhaseChange(it.phase))
    mission = state.mission
    handling = mission.handling
    if handling and it.phase != handling and not it.phase.startswith(f"{handling}/"):
        mission = mission._replace(handling="")
    mission = _counted(mission.at(it.next), mission.clock(moment.now_s))
    state = state._replace(mission=mission)
    message = _too_fast(moment.program, mission)
    return end_by_fault(moment, state, RUNAWAY, message) if message else state


def _do(moment: Moment, state: EngineState, it: Do) -> EngineState:
    mission = state.mission
    name = moment.robot.commands[it.command].name
    if mission.begun:
        return _awaited(moment, state, it, name)
    if state.robot.awaited is not None or state.robot.motion is not None:
        return state  # the array in flight is resolved first
    state = lapse_unheard(moment, state)
    reason = command_outcome.refusal(moment.robot, state.robot, it.command)
    known = declared_states.as_last_seen(state.robot) if reason else state.robot
    if reason and not command_outcome.refusal(moment.robot, known, it.command):
        waiting = _awaiting_sight(moment, state)
        if waiting is not None:
            return waiting
    if reason.startswith("unneeded") and it.skip_unneeded:
        moment.emit(CommandStatus(name, "skipped", reason, it.place))
        return go(state, it.next)
    if reason:
        moment.emit(CommandStatus(name, "refused", reason, it.place))
        cause = f"{name} ({it.place}) was refused as {reason}"
        return fail(moment, state, cause, it.failed)
    trial = moment.trial()
    robot = commands.begin(trial, state.robot, state.sensing, it.command, it.timeout_s, it.place)
    forbidden = safety.forbids(moment, state.rules, robot)
    if forbidden:
        message = f"{name} ({it.place}) would break {forbidden}"
        return end_by_fault(moment, state, safety.RULE_BROKEN, message)
    moment.effects += trial.effects
    mission = mission._replace(begun=True, result=None, since=())
    return state._replace(robot=robot, mission=mission)


def _awaiting_sight(moment: Moment, state: EngineState) -> EngineState | None:
    """Return the state in which a step waits for sensors to show a clamp; None if it has waited."""
    mission = state.mission
    if mission.since:
        return None
    mission = mission._replace(since=(mission.clock(moment.now_s),))
    return flow.pause_until_seen(moment, state._replace(mission=mission))


def _awaited(moment: Moment, state: EngineState, it: Do, name: str) -> EngineState:
    mission = state.mission
    if mission.skipped is not None and state.robot.awaited is None:
        robot = commands.skip(moment, state.robot)
        return go(state._replace(robot=robot), it.next)
    if mission.result is None:
        return state
    if mission.result.done:
        return go(state, it.next)
    if mission.tries < it.retries:
        moment.take("retry", it.place)
        again = mission._replace(begun=False, result=None, tries=mission.tries + 1)
        return state._replace(mission=again)
    cause = f"{name} ({it.place}) failed: {mission.result.reason}"
    return fail(moment, state, cause, it.failed)


def _switch_control(moment: Moment, state: EngineState, it: SwitchControl) -> EngineState:
    mission, body = state.mission, state.robot
    if body.awaited is not None or body.motion is not None:
        return state  # the array in flight is resolved first
    clock = mission.clock(moment.now_s)
    if not mission.begun:
        robot = commands.switch_control(moment, body, state.sensing, it.control)
        mission = mission._replace(begun=True, armed_s=clock)
        state = state._replace(robot=robot, mission=mission)
        if robot.awaited is not None:
            return state
    late = unsettled(state.robot, state.sensing)
    failed = mission.result is not None  # a script says so
    if not failed and (moment.nominal or mission.skipped is not None or not late):
        return go(state, it.next)
    if failed or has_come(clock, mission.armed_s + it.timeout_s):
        name = moment.robot.controls[it.control].name
        slots = ", ".join(moment.robot.slots[slot].name for slot in late)
        limit = f"{it.timeout_s:g} s"
        cause = f"control {name} ({it.place}): {slots} did not bear the torque within {limit}"
        return fail(moment, state, cause, it.failed)
    return state


def _branch(moment: Moment, state: EngineState, it: Branch) -> EngineState:
    value = it.condition.evaluate(state.sensing.shown, state.words)
    if value is None:
        moment.warn(f"{it.place}: '{it.condition.text}' is unknown, not taken")
    moment.take("if" if value is True else "else", it.place)
    return go(state, it.if_true if value is True else it.if_false)


def _require(moment: Moment, state: EngineState, it: Require) -> EngineState:
    reason = _lacks(moment, state.robot, it)
    if not reason:
        return go(state, it.next)
    if not _lacks(moment, declared_states.as_last_seen(state.robot), it):
        waiting = _awaiting_sight(moment, state)
        if waiting is not None:
            return waiting
    moment.emit(CommandStatus(it.what, "refused", f"impossible: {reason}", it.place))
    cause = f"{it.what} ({it.place}) cannot begin: {reason}"
    return fail(moment, state, cause, it.failed)


def _lacks(moment: Moment, body: RobotState, it: Require) -> str:
    """Return in words which required states the robot is not in; empty if it is in all."""
    names = robot_state.states_of(moment.robot, body)
    # States that any accepted array confirms will hold with the called mission's first command.
    open_ = body.marks - declared_states.awaiting(moment.robot, body)
    doubtful = robot_state.unconfirmed(moment.robot, body._replace(marks=open_))
    return "; ".join(
        f"{moment.robot.regions[region]} is {names[region]}"
        + (" unconfirmed" if moment.robot.regions[region] in doubtful else "")
        + f", not {wanted}"
        for region, wanted in it.states
        if names[region] != wanted or moment.robot.regions[region] in doubtful
    )


def _say(moment: Moment, state: EngineState, it: Say) -> EngineState:
    moment.emit(Log(it.level, with_measured(moment, state, it.message)))
    return go(state, it.next)


def _raise(moment: Moment, state: EngineState, it: Raise) -> EngineState:
    return fail(
        moment, state, f"{with_measured(moment, state, it.message)} ({it.place})", it.failed
    )


def _finish(moment: Moment, state: EngineState, it: Finish) -> EngineState:
    message = with_measured(moment, state, it.message, "no failure")
    if it.outcome == "succeeded":
        met = met_unknown(moment, state)
        if met is not None:
            return met
    return end(moment, state, it.outcome, message, it.end)


RUNAWAY = BuiltInFault.MISSION_RUNAWAY.code
"""The fault of a mission whose phases follow each other faster than sensors report."""

MOST_TURNS = 4
"""How often one instruction may be reached at the same time. It is reached again only after an
answer of the operator or at the end of a fault's handling; more often means an endless loop."""


def _counted(mission: MissionState, clock: float) -> MissionState:
    """Return the mission with one more phase counted."""
    if clock >= mission.second_s + 1.0:
        return mission._replace(second_s=clock, entered=1)
    return mission._replace(entered=mission.entered + 1)


def _too_fast(program: Program, mission: MissionState) -> str:
    """Return why the mission must end; empty while it may continue.

    The limit grows with the length of the mission. Phases that repeat without any time passing
    are reported separately.
    """
    most = max(program.most_phases, MOST_TURNS * len(program.instructions))
    if mission.entered <= most:
        return ""
    return f"more than {most:g} phases have begun within a second"
