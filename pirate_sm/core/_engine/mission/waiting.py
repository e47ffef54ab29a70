"""Execute waits and questions, with what a mission claims by a distance; find its next deadline."""

from __future__ import annotations

from math import ceil, inf, isnan, nan

from pirate_sm.core._engine.mission.flow import fail, go, meet, moved
from pirate_sm.core._engine.mission.program import (
    DRIVEN,
    Question,
    SwitchControl,
    TriggerSpec,
    Wait,
)
from pirate_sm.core._engine.moment import Moment, has_come
from pirate_sm.core._engine.robot.command_outcome import unmet_of
from pirate_sm.core._engine.robot.criteria import near
from pirate_sm.core._engine.safety import FoundFault
from pirate_sm.core._engine.sensing.known_signals import with_changes
from pirate_sm.core._engine.sensing.odometry import BASE_M
from pirate_sm.core._engine.state import OUTSIDE, Counted, EngineState, MissionState, Words
from pirate_sm.core._expressions.vocabulary import change_of
from pirate_sm.core._model.faults import BuiltInFault
from pirate_sm.core._model.unmet import shown_words
from pirate_sm.core.effects import TAKEN, Ask, TriggerFired, WaitArmed


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
        moment.take("within", it.place)
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
    moment.take("trigger", trigger.place, trigger.name)
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
                moment.take("choice", it.place, choice)
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
        shown = unmet_of(robot, origin, near(signal, 0.0, inf), seen, moment.now_s)
        words = shown_words(shown, with_change=it.compares)
        found[f"{shown.signal} {words}"] = None
    return list(found)


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


# --- what a mission claims by a distance, and whether its bound bears that --------------------


_LEAST_M, _SHARE = 0.020, 0.25
"""A success by a distance needs a bound of at most this share of what was driven for it, and never
less than the first [decided]. A mission asks for more by ``known within``."""


def claim_of(moment: Moment, state: EngineState, trigger: TriggerSpec) -> Counted | None:
    """Return from where the distance counts that the mission claims after this trigger has fired.

    None where it claims none: a word of the detector says anew where the robot is. What else a
    trigger has asked for leaves the claim of before.
    """
    robot, names = moment.robot, trigger.condition.names if trigger.condition else frozenset()
    odometry = robot.vocabulary.numbers[robot.odometry] if robot.odometry >= 0 else ""
    if change_of(odometry) in names:
        return state.mission.counts_from
    if odometry in names:
        return Counted()
    return None if OUTSIDE[0] in names else state.mission.claim


def counted(moment: Moment, state: EngineState) -> Counted:
    """Return the distance as it is now, from which later ones can count."""
    at, memory = moment.robot.odometry, state.sensing.distance
    odometry_m = state.sensing.numbers[at] if at >= 0 else 0.0
    late_m = max(0.0, memory.late_m - BASE_M)
    return Counted(odometry_m, memory.width_m, memory.rolled_m, late_m)


def met_unknown(moment: Moment, state: EngineState, within_m: float = inf) -> EngineState | None:
    """Return the state after the fault that the bound is too wide for what the mission claims.

    None where it is not, and where the mission continues in spite of the fault.

    Args:
        moment: The time, the robot and program, and the effects so far.
        state: The state.
        within_m: The bound that the mission asks for.
    """
    claim, bounded = state.mission.claim, state.sensing.distance.every_s > 0.0
    if claim is None or not bounded:  # a trace, or a recording of before
        return None
    way_m, bound_m, limit_m = _driven(moment, state, claim)
    limit_m = min(within_m, limit_m)
    if bound_m <= limit_m:
        return None
    message = f"the wheels show {way_m * 1000:.0f} mm, but the robot may be {bound_m * 1000:.0f} mm"
    message += f" from there; this must be known within {limit_m * 1000:.0f} mm"
    met = meet(moment, state, FoundFault.built_in(BuiltInFault.DISTANCE_UNKNOWN, message))
    return None if met.mission is state.mission else met


def with_measured(moment: Moment, state: EngineState, text: str, no_cause: str = "") -> str:
    """Return a text of the mission, with the last cause and what it has driven as measured.

    What was asked for is not what was measured: a brake that comes late adds to the way.
    """
    text = text.replace("{cause}", state.mission.cause or no_cause)
    if DRIVEN not in text:
        return text
    since = state.mission.claim or state.mission.counts_from
    way_m, bound_m, limit_m = _driven(moment, state, since)
    bounded = state.sensing.distance.every_s > 0.0
    driven = f"{way_m * 1000:z.0f} ± {ceil(bound_m * 1000)} mm" if bounded else ""
    if isnan(way_m) or (bounded and bound_m > limit_m):
        driven = "an unknown distance"
    return text.replace(DRIVEN, driven or f"{way_m * 1000:z.0f} mm")


def _driven(moment: Moment, state: EngineState, since: Counted) -> tuple[float, float, float]:
    """Return the distance driven since then, its bound, and the largest bound of a success, m."""
    now = counted(moment, state)
    limit_m = max(_LEAST_M, _SHARE * (now.rolled_m - since.rolled_m))
    bound_m = state.sensing.distance.bound_m - since.width_m + since.late_m
    return now.odometry_m - since.odometry_m, bound_m, limit_m
