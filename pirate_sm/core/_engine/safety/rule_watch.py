"""Check the safety rules during a run; a broken rule ends the mission."""

from __future__ import annotations

from functools import partial

from pirate_sm.core._engine.mission import pausing
from pirate_sm.core._engine.mission.ending import end_by_fault
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import confirmation
from pirate_sm.core._engine.safety import rules
from pirate_sm.core._engine.state import EngineState


def watch(moment: Moment, before: EngineState, state: EngineState) -> EngineState:
    """Update the progress of the rules, and end a mission that breaks one.

    If a command of the operator breaks a rule, a warning is emitted and the mission continues. If
    only a clamp is missing whose sensors are not known now, it pauses until they show it again.
    """
    if not state.rules:
        return state
    old, new = before.robot, state.robot
    motion = new.motion or old.motion
    accepted = old.configuration != new.configuration
    if not accepted and old.marks == new.marks and old.values == new.values:
        return state
    diverting = state.mission.diverting is not None or state.look is not None
    if not accepted and diverting:
        return state
    name = moment.robot.commands[motion.command].name if motion is not None else None
    follow = partial(rules.follow, moment.program, moment.robot, state.rules)
    accepts = int(accepted), name if accepted else None
    places, broken = follow(new, *accepts)
    unseen = bool(broken) and not follow(confirmation.as_last_seen(new), *accepts)[1]
    if places != state.rules:
        state = state._replace(rules=places)
    # While a fault is being handled the mission breaks no rule: rules were checked before its last
    # command was sent, and its wheels are stopped before the handler begins. While sensors are
    # compared with states no command begins either.
    for rule in () if diverting else broken:
        if motion is not None and not motion.place:
            moment.warn(f"{name}, given by hand, violates {rules.said(rule)}")
        elif state.mission.ending or state.mission.ended:
            pass
        elif unseen:
            return pausing.until_seen(moment, state)  # once, whatever rules are broken
        else:
            state = end_by_fault(moment, state, rules.CODE, rules.said(rule))
    return state
