"""The rules of a robot are watched: what breaks one ends the mission (see ``engine.safety.rules``)."""

from __future__ import annotations

from pirate_sm.engine.mission.ending import end
from pirate_sm.engine.safety import rules
from pirate_sm.engine.state import EngineState, Setting
from pirate_sm.model.effects import Effect, Fault, Log


def watch(
    setting: Setting, before: EngineState, state: EngineState, now: float, effects: list[Effect]
) -> EngineState:
    """The rules know what has become of the robot; one that the mission breaks ends it.

    What the operator commands is theirs to answer for: it is told, and the mission goes on.
    """
    old, new = before.robot, state.robot
    motion = new.motion or old.motion
    accepted = old.configuration != new.configuration
    if not accepted and old.marks == new.marks and old.values == new.values:
        return state
    diverting = state.mission.diverting is not None
    if not accepted and diverting:
        return state
    name = setting.robot.commands[motion.command].name if motion is not None else None
    places, broken = rules.follow(
        setting.program, setting.robot, state.rules, new, int(accepted), name if accepted else None
    )
    if places != state.rules:
        state = state._replace(rules=places)
    # Where a fault leads elsewhere the mission has broken nothing: rules were asked before its last
    # command was sent, and its wheels are stopped before the handler begins.
    for rule in () if diverting else broken:
        if motion is not None and not motion.place:
            effects.append(Log("warning", f"{name}, given by hand, violates {rules.said(rule)}"))
        elif not (state.mission.ending or state.mission.ended):
            effects.append(Fault(rules.CODE, rules.said(rule), "stop"))
            state = end(
                setting, state, "fault", f"{rules.CODE}: {rules.said(rule)}", "", now, effects
            )
    return state
