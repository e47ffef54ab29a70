"""Find outcomes of waits that need sensors to alternate between values.

The exploration tells states of a wait apart by which conditions have begun to hold, not by when.
So it does not see a wait that goes on because first one condition breaks and then another one,
such as ``known(x)`` and ``not known(x)``, each to be held for 2 s, with ``within`` 3 s. What a
wait can come to so is worked out here: sensors may change at any time and as often as need be.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite, nan

from pirate_sm.checking.exploring.answers import Fact
from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.engine.mission.program import TriggerSpec, Wait
from pirate_sm.engine.state import EngineState

LEAST_RIVALS = 2
"""Of fewer conditions none has to break in turn: the exploration finds what they lead to."""


def lasting(
    wait: Wait, state: EngineState, conditions: Conditions
) -> Iterator[tuple[EngineState, float]]:
    """Yield states just before an outcome of the wait, each with the time at which it comes.

    In one of them a condition has been true all the time, or none has, and no other one for as
    long as it would have to be.

    Args:
        wait: What waits.
        state: In which it has just begun to.
        conditions: What can be true together.
    """
    limit_s = min([wait.within_s, *(t.after_s for t in wait.triggers if t.after_s is not None)])
    for chosen in (-1, *(n for n, each in enumerate(wait.triggers) if _is_held(each))):
        after_s = limit_s if chosen < 0 else wait.triggers[chosen].held_s
        if not isfinite(after_s) or after_s > limit_s:
            continue
        rivals = [
            each
            for number, each in enumerate(wait.triggers)
            if _is_held(each)
            and number != chosen
            and (each.held_s, number) < (after_s, len(wait.triggers) if chosen < 0 else chosen)
        ]
        if len(rivals) < LEAST_RIVALS or not _can_last(wait, chosen, rivals, state, conditions):
            continue
        armed_s = state.mission.armed_s
        since = tuple(armed_s if n == chosen else nan for n in range(len(wait.triggers)))
        yield state._replace(mission=state.mission._replace(since=since)), armed_s + after_s


def _is_held(trigger: TriggerSpec) -> bool:
    return trigger.condition is not None and trigger.held_s > 0


def _can_last(
    wait: Wait, chosen: int, rivals: list[TriggerSpec], state: EngineState, conditions: Conditions
) -> bool:
    """Return whether each rival can break while the chosen condition holds and nothing fires."""
    facts: list[Fact] = [
        (each.condition.tree, False)
        for each in wait.triggers
        if each.condition is not None and each.held_s == 0
    ]
    held = wait.triggers[chosen].condition if chosen >= 0 else None
    if held is not None:
        facts.append((held.tree, True))
    return all(
        conditions.ask((*facts, (each.condition.tree, False)), state.words).possible
        for each in rivals
        if each.condition is not None
    )
