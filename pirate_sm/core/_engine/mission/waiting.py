"""Execute waits and questions, and compute the next deadline of the mission."""

from __future__ import annotations

from math import inf, isnan, nan

from pirate_sm.core._engine.deadlines import has_come
from pirate_sm.core._engine.mission.claims import claim_of, counted, met_unknown
from pirate_sm.core._engine.mission.going_on import fail, go, moved
from pirate_sm.core._engine.mission.program import Question, SwitchControl, TriggerSpec, Wait
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot.done import Limit
from pirate_sm.core._engine.robot.unmet_conditions import unmet_of
from pirate_sm.core._engine.sensing.known_signals import with_changes
from pirate_sm.core._engine.state import EngineState, MissionState, Words
from pirate_sm.core._model.effects import TAKEN, Ask, TriggerFired, WaitArmed
from pirate_sm.core._model.unmet_words import shown_words


def next_deadline(moment: Moment, state: EngineState) -> float:
    """Return the next time at which the mission continues without an event, in run time."""
    mission = state.mission
    if mission.ending:
        return mission.ending.give_up_s
    if mission.paused or mission.ended:
        # Neither during a comparison nor before the fate of an array is known does it go on.
        held_up = state.look is not None or state.robot.awaited is not None
        return inf if held_up else mission.sight_until_s
    deadline = moment.program.time_limit_s
    instruction = moment.program.instructions[mission.pc]
    if mission.diverting or mission.pause_wanted:
        pass  # the result of the array in flight comes first
    elif mission.begun and isinstance(instruction, Wait):
        deadline = min(deadline, mission.armed_s + instruction.within_s)
        for trigger, since in zip(instruction.triggers, mission.since, strict=True):
            if trigger.after_s is not None:
                deadline = min(deadline, mission.armed_s + trigger.after_s)
            elif not isnan(since):
                deadline = min(deadline, since + trigger.held_s)
    elif mission.begun and isinstance(instruction, Question | SwitchControl):
        switches = isinstance(instruction, SwitchControl)
        counts = not switches or state.robot.awaited is None  # the array's fate comes first
        deadline = min(deadline, mission.armed_s + instruction.timeout_s) if counts else deadline
    return deadline + mission.offset_s


def wait(moment: Moment, state: EngineState, it: Wait) -> EngineState:
    """Arm a wait, and continue once a trigger fires or the time limit has passed."""
    mission = state.mission
    clock = mission.clock(moment.now_s)
    if not mission.begun:
        since = (nan,) * len(it.triggers)
        mission = mission._replace(begun=True, armed_s=clock, since=since)
        if it.compares and not (it.counts_on and mission.origin):
            origin, from_here = state.sensing.counted, counted(moment, state)
            mission = mission._replace(origin=origin, counts_from=from_here)
        deadline = clock + it.within_s + mission.offset_s
        names = tuple(trigger.name for trigger in it.triggers)
        texts = tuple(trigger.text for trigger in it.triggers)
        moment.emit(WaitArmed(it.phase, names, texts, deadline, it.place))
        state = state._replace(mission=mission)
    sensing = state.sensing
    numbers = with_changes(sensing, mission.origin) if it.compares else sensing.shown
    since, fired, reason = _look(it, mission, numbers, state.words, clock)
    if fired >= 0:
        return _fire(moment, state, it, fired, reason)
    if has_come(clock, mission.armed_s + it.within_s):
        cause = f"the wait of {it.phase} ({it.place}) lasted longer than {it.within_s:g} s"
        if awaited := _unmet_wait(moment, state, it):
            cause = f"{cause}: it awaited {awaited}"
        moment.emit(TriggerFired(it.phase, "within", it.within_name, cause, it.place))
        if it.fails:
            return fail(moment, state, cause, it.within)
        mission = mission._replace(cause=cause)
        return state._replace(mission=moved(mission, it.within))
    if mission.skipped:
        moment.warn(f"{it.phase} does not wait for '{mission.skipped}'")
    if since is mission.since:
        return state
    return state._replace(mission=mission._replace(since=since))


def _fire(moment: Moment, state: EngineState, it: Wait, fired: int, reason: str) -> EngineState:
    """Return the state after a trigger; one that needs a bound needs it now."""
    trigger, skipped = it.triggers[fired], state.mission.skipped is not None
    claim = None if skipped else claim_of(moment, state, trigger)
    state = state._replace(mission=state.mission._replace(claim=claim))
    if trigger.known_within_m < inf and not skipped:
        met = met_unknown(moment, state, trigger.known_within_m)
        if met is not None:
            return met
    moment.emit(TriggerFired(it.phase, trigger.name, trigger.go_name, reason, it.place))
    return go(state, trigger.go)


def _look(
    it: Wait, mission: MissionState, numbers: tuple[float, ...], words: Words, clock: float
) -> tuple[tuple[float, ...], int, str]:
    """Return when each condition became true, the trigger that fires (-1: none), and why."""
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
    """Return whether a time trigger is due, or the answer of an operator trigger has come."""
    if trigger.after_s is not None:
        return has_come(clock, mission.armed_s + trigger.after_s)
    return trigger.answer == mission.answer


def question(moment: Moment, state: EngineState, it: Question) -> EngineState:
    """Ask the operator, and continue once there is an answer or the timeout has passed."""
    mission = state.mission
    clock = mission.clock(moment.now_s)
    choices = tuple(choice for choice, _ in it.choices)
    if not mission.begun:
        moment.emit(Ask(it.text, choices))
        return state._replace(mission=mission._replace(begun=True, armed_s=clock))
    answer = choices[0] if mission.skipped is not None else mission.answer
    if answer is not None:
        for choice, target in it.choices:
            if choice == answer:
                moment.emit(Ask("", ()))
                mission = mission._replace(cause=f"the operator answered '{answer}' ({it.place})")
                return state._replace(mission=moved(mission, target))
        moment.warn(f"'{answer}' is no answer to '{it.text}'")
        return state._replace(mission=mission._replace(answer=None))
    if has_come(clock, mission.armed_s + it.timeout_s):
        cause = f"'{it.text}' ({it.place}) was not answered within {it.timeout_s:g} s"
        return fail(moment, state, cause, it.failed)
    return state


def _unmet_wait(moment: Moment, state: EngineState, it: Wait) -> str:
    """Return the conditions of a wait whose time is over, each with what its signals show.

    It is empty for a wait without conditions, and in a trace, where no sensor shows anything.
    """
    if moment.nominal:
        return ""
    return " or ".join(
        f"'{trigger.text}' ({', '.join(_shown(moment, state, it, trigger))})"
        for trigger in it.triggers
        if trigger.condition is not None and trigger.condition.names
    )


def _shown(moment: Moment, state: EngineState, it: Wait, trigger: TriggerSpec) -> list[str]:
    """Return the signals of a condition with what they show."""
    assert trigger.condition is not None  # the caller has looked
    robot = moment.robot
    vocabulary = robot.vocabulary.with_changes if it.compares else robot.vocabulary
    found: dict[str, None] = {}
    for name in sorted(trigger.condition.names):
        slot = vocabulary.slot(name)
        if slot.kind == "word":
            found[f"{name} is {state.words[slot.index] or 'unknown'}"] = None
            continue
        signal = slot.index % len(robot.vocabulary.numbers)  # of a change: that which changes
        origin, seen = state.mission.origin, state.sensing
        shown = unmet_of(robot, origin, Limit(signal, -inf, inf), seen, moment.now_s)
        words = shown_words(shown, with_change=it.compares)
        found[f"{shown.signal} {words}"] = None
    return list(found)
