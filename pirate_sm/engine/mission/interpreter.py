"""Execute the mission's instructions, one function per kind (rules: docs/missions.md)."""

from __future__ import annotations

from math import inf, isnan, nan
from typing import assert_never

from pirate_sm.engine.deadlines import has_come
from pirate_sm.engine.mission.ending import end, end_by_fault, withdraw
from pirate_sm.engine.mission.phase_rate import MOST_TURNS, RUNAWAY, counted, too_fast
from pirate_sm.engine.mission.program import (
    STOP,
    Branch,
    Do,
    Enter,
    Finish,
    Instruction,
    Question,
    Raise,
    Require,
    Say,
    TriggerSpec,
    Wait,
)
from pirate_sm.engine.moment import Moment
from pirate_sm.engine.robot import commands, confirmation, robot_state
from pirate_sm.engine.safety import rules
from pirate_sm.engine.sensing.conversion import with_changes
from pirate_sm.engine.state import EngineState, MissionState, Words
from pirate_sm.model.effects import (
    TAKEN,
    Ask,
    CommandStatus,
    Log,
    PhaseChange,
    TriggerFired,
    WaitArmed,
)

ROUND_AND_ROUND = "the phases go round without ever waiting"


def advance(moment: Moment, state: EngineState) -> EngineState:
    """Execute instructions until one has to wait.

    Once its time is up no command begins any more; what else is due now comes before (rule 6).
    """
    instructions = moment.program.instructions
    for _ in range(MOST_TURNS * len(instructions)):
        mission = state.mission
        if mission.ending or mission.ended:
            return state
        if mission.diverting or mission.paused or mission.pause_wanted:
            return state
        instruction = instructions[mission.pc]
        begins = type(instruction) is Do and not mission.begun
        if begins and has_come(mission.clock(moment.now_s), moment.program.time_limit_s):
            return state
        after = _execute(moment, state, instruction)
        if after.mission.pc == mission.pc and after.mission.begun:
            return after
        if after is state:
            return state
        state = after
    return end(moment, state, "failed", ROUND_AND_ROUND)


def _execute(moment: Moment, state: EngineState, it: Instruction) -> EngineState:
    match it:
        case Wait():
            return _wait(moment, state, it)
        case Do():
            return _do(moment, state, it)
        case Enter():
            return _enter(moment, state, it)
        case Branch():
            return _branch(moment, state, it)
        case Require():
            return _require(moment, state, it)
        case Question():
            return _question(moment, state, it)
        case Say():
            return _say(moment, state, it)
        case Raise():
            return _raise(moment, state, it)
        case Finish():
            return _finish(moment, state, it)
        case _:
            assert_never(it)


def without_requests(moment: Moment, state: EngineState) -> MissionState:
    """Return the mission without the operator's answer and skip, which have had their effect.

    A skip is kept while a command's array is in flight: whether that has moved the chart is not
    known before.
    """
    mission = state.mission
    doing = mission.begun and isinstance(moment.program.instructions[mission.pc], Do)
    waits = doing and state.robot.awaited is not None
    return mission._replace(answer=None, skipped=mission.skipped if waits else None)


def fail(moment: Moment, state: EngineState, cause: str, target: int) -> EngineState:
    """Go where the failure leads; without a handler end the mission as failed (rule 4).

    A failure that is passed over leaves an earlier cause, the one that led here, as it is.
    """
    passed_over = target == getattr(moment.program.instructions[state.mission.pc], "next", STOP)
    kept = state.mission.cause if passed_over else ""
    mission = state.mission._replace(cause=kept or cause)
    if target == STOP:
        state = state._replace(mission=mission)
        return end(moment, state, "failed", cause)
    withdraw(moment, state)
    moment.warn(cause)
    return state._replace(mission=_moved(mission, target))


def next_deadline(moment: Moment, state: EngineState) -> float:
    """Return when time alone takes the mission on, in run time."""
    mission = state.mission
    if mission.ending:
        return mission.ending.give_up_s
    if mission.paused or mission.ended:
        return inf
    deadline = moment.program.time_limit_s
    instruction = moment.program.instructions[mission.pc]
    if mission.diverting or mission.pause_wanted:
        pass  # what is in flight comes first
    elif mission.begun and isinstance(instruction, Wait):
        deadline = min(deadline, mission.armed_s + instruction.within_s)
        for trigger, since in zip(instruction.triggers, mission.since, strict=True):
            if trigger.after_s is not None:
                deadline = min(deadline, mission.armed_s + trigger.after_s)
            elif not isnan(since):
                deadline = min(deadline, since + trigger.held_s)
    elif mission.begun and isinstance(instruction, Question):
        deadline = min(deadline, mission.armed_s + instruction.timeout_s)
    return deadline + mission.offset_s


def _moved(mission: MissionState, target: int) -> MissionState:
    mission = mission.at(target)
    if mission.one_step:
        return mission._replace(one_step=False, pause_wanted=True)
    return mission


def _go(state: EngineState, target: int) -> EngineState:
    return state._replace(mission=_moved(state.mission, target))


def _enter(moment: Moment, state: EngineState, it: Enter) -> EngineState:
    moment.tell(PhaseChange(it.phase))
    mission = state.mission
    handling = mission.handling
    if handling and it.phase != handling and not it.phase.startswith(f"{handling}/"):
        mission = mission._replace(handling="")
    mission = counted(mission.at(it.next), mission.clock(moment.now_s))
    state = state._replace(mission=mission)
    message = too_fast(moment.program, mission)
    return end_by_fault(moment, state, RUNAWAY, message) if message else state


def _do(moment: Moment, state: EngineState, it: Do) -> EngineState:
    mission = state.mission
    name = moment.robot.commands[it.command].name
    if mission.begun:
        return _awaited(moment, state, it, name)
    if state.robot.awaited is not None or state.robot.motion is not None:
        return state  # the array in flight is resolved first
    reason = robot_state.refusal(moment.robot, state.robot, it.command)
    if reason.startswith("unneeded") and it.skip_unneeded:
        moment.tell(CommandStatus(name, "skipped", reason, it.place))
        return _go(state, it.next)
    if reason:
        moment.tell(CommandStatus(name, "refused", reason, it.place))
        cause = f"{name} ({it.place}) was refused as {reason}"
        return fail(moment, state, cause, it.failed)
    trial = moment.trial()
    robot = commands.begin(trial, state.robot, state.sensing, it.command, it.timeout_s, it.place)
    forbidden = rules.forbids(moment, state.rules, robot)
    if forbidden:
        message = f"{name} ({it.place}) would break {forbidden}"
        return end_by_fault(moment, state, rules.CODE, message)
    moment.effects += trial.effects
    return state._replace(robot=robot, mission=mission._replace(begun=True, result=None))


def _awaited(moment: Moment, state: EngineState, it: Do, name: str) -> EngineState:
    mission = state.mission
    if mission.skipped is not None and state.robot.awaited is None:
        robot = commands.skip(moment, state.robot)
        return _go(state._replace(robot=robot), it.next)
    if mission.result is None:
        return state
    if mission.result.done:
        return _go(state, it.next)
    if mission.tries < it.retries:
        again = mission._replace(begun=False, result=None, tries=mission.tries + 1)
        return state._replace(mission=again)
    cause = f"{name} ({it.place}) failed: {mission.result.reason}"
    return fail(moment, state, cause, it.failed)


def _branch(moment: Moment, state: EngineState, it: Branch) -> EngineState:
    value = it.condition.evaluate(state.sensing.shown, state.words)
    if value is None:
        moment.warn(f"{it.place}: '{it.condition.text}' is unknown, not taken")
    return _go(state, it.if_true if value is True else it.if_false)


def _require(moment: Moment, state: EngineState, it: Require) -> EngineState:
    names = robot_state.states_of(moment.robot, state.robot)
    # What any accepted array confirms is so as soon as the called mission commands something.
    open_ = state.robot.marks - confirmation.awaiting(moment.robot, state.robot)
    doubtful = robot_state.unconfirmed(moment.robot, state.robot._replace(marks=open_))
    wrong = [
        f"{moment.robot.regions[region]} is {names[region]}"
        + (" unconfirmed" if moment.robot.regions[region] in doubtful else "")
        + f", not {wanted}"
        for region, wanted in it.states
        if names[region] != wanted or moment.robot.regions[region] in doubtful
    ]
    if not wrong:
        return _go(state, it.next)
    reason = "; ".join(wrong)
    moment.tell(CommandStatus(it.what, "refused", f"impossible: {reason}", it.place))
    cause = f"{it.what} ({it.place}) cannot begin: {reason}"
    return fail(moment, state, cause, it.failed)


def _wait(moment: Moment, state: EngineState, it: Wait) -> EngineState:
    mission = state.mission
    clock = mission.clock(moment.now_s)
    if not mission.begun:
        since = (nan,) * len(it.triggers)
        origin = state.sensing.shown if it.compares else ()
        mission = mission._replace(begun=True, armed_s=clock, since=since, origin=origin)
        deadline = clock + it.within_s + mission.offset_s
        names = tuple(trigger.name for trigger in it.triggers)
        texts = tuple(trigger.text for trigger in it.triggers)
        moment.tell(WaitArmed(it.phase, names, texts, deadline, it.place))
        state = state._replace(mission=mission)
    sensing = state.sensing
    numbers = with_changes(sensing, mission.origin) if it.compares else sensing.shown
    since, fired, reason = _look(it, mission, numbers, state.words, clock)
    if fired >= 0:
        trigger = it.triggers[fired]
        moment.tell(TriggerFired(it.phase, trigger.name, trigger.go_name, reason, it.place))
        return _go(state, trigger.go)
    if has_come(clock, mission.armed_s + it.within_s):
        cause = f"the wait of {it.phase} ({it.place}) lasted longer than {it.within_s:g} s"
        moment.tell(TriggerFired(it.phase, "within", it.within_name, cause, it.place))
        if it.fails:
            return fail(moment, state, cause, it.within)
        mission = mission._replace(cause=cause)
        return state._replace(mission=_moved(mission, it.within))
    if mission.skipped:
        moment.warn(f"{it.phase} does not wait for '{mission.skipped}'")
    if since is mission.since:
        return state
    return state._replace(mission=mission._replace(since=since))


def _look(
    it: Wait, mission: MissionState, numbers: tuple[float, ...], words: Words, clock: float
) -> tuple[tuple[float, ...], int, str]:
    """Return since when each condition is true, the trigger that fires (-1: none), and why."""
    if mission.skipped is not None:
        for index, trigger in enumerate(it.triggers):
            if mission.skipped in {"", trigger.name}:
                return mission.since, index, TAKEN
    since = mission.since
    for index, trigger in enumerate(it.triggers):
        if trigger.condition is None:
            if _is_time(trigger, mission, clock):
                return since, index, trigger.text
            continue
        began = since[index]
        if trigger.condition.evaluate(numbers, words) is True:
            began = clock if isnan(began) else began
            if has_come(clock, began + trigger.held_s):  # rule 7
                return since, index, trigger.text
        else:
            began = nan
        if began != since[index] and not (isnan(began) and isnan(since[index])):
            since = (*since[:index], began, *since[index + 1 :])
    return since, -1, ""


def _is_time(trigger: TriggerSpec, mission: MissionState, clock: float) -> bool:
    """Whether a trigger without a condition fires: its time has come, or its answer."""
    if trigger.after_s is not None:
        return has_come(clock, mission.armed_s + trigger.after_s)
    return trigger.answer == mission.answer


def _question(moment: Moment, state: EngineState, it: Question) -> EngineState:
    mission = state.mission
    clock = mission.clock(moment.now_s)
    choices = tuple(choice for choice, _ in it.choices)
    if not mission.begun:
        moment.tell(Ask(it.text, choices))
        return state._replace(mission=mission._replace(begun=True, armed_s=clock))
    answer = choices[0] if mission.skipped is not None else mission.answer
    if answer is not None:
        for choice, target in it.choices:
            if choice == answer:
                moment.tell(Ask("", ()))
                mission = mission._replace(cause=f"the operator answered '{answer}' ({it.place})")
                return state._replace(mission=_moved(mission, target))
        moment.warn(f"'{answer}' is no answer to '{it.text}'")
        return state._replace(mission=mission._replace(answer=None))
    if has_come(clock, mission.armed_s + it.timeout_s):
        cause = f"'{it.text}' ({it.place}) was not answered within {it.timeout_s:g} s"
        return fail(moment, state, cause, it.failed)
    return state


def _say(moment: Moment, state: EngineState, it: Say) -> EngineState:
    moment.tell(Log(it.level, it.message.replace("{cause}", state.mission.cause)))
    return _go(state, it.next)


def _raise(moment: Moment, state: EngineState, it: Raise) -> EngineState:
    cause = it.message.replace("{cause}", state.mission.cause)
    return fail(moment, state, f"{cause} ({it.place})", it.failed)


def _finish(moment: Moment, state: EngineState, it: Finish) -> EngineState:
    message = it.message.replace("{cause}", state.mission.cause or "no failure")
    return end(moment, state, it.outcome, message, it.end)
