"""Say what a wait has awaited in vain, and what its signals show."""

from __future__ import annotations

from math import inf

from pirate_sm.engine.mission.program import TriggerSpec, Wait
from pirate_sm.engine.moment import Moment
from pirate_sm.engine.robot.done import Limit
from pirate_sm.engine.robot.unmet_conditions import unmet_of
from pirate_sm.engine.state import EngineState
from pirate_sm.model.unmet_words import shown_words


def unmet_wait(moment: Moment, state: EngineState, it: Wait) -> str:
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
