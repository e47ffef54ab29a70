"""Find outcomes of waits that require sensors to alternate between values.

The exploration distinguishes states of a wait by which conditions have become true, not by when.
It therefore misses a wait that continues because first one condition breaks and then another, such
as ``known(x)`` and ``not known(x)``, each held for 2 s, with ``within`` 3 s. This module finds such
outcomes: sensors may change at any time and any number of times.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite, nan

from pirate_sm.checking.exploring.answers import Fact
from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.core.engine import EngineState
from pirate_sm.core.program import TriggerSpec, Wait

LEAST_RIVALS = 2
"""Smallest number of conditions that can alternate; the exploration covers fewer."""


def lasting(
    wait: Wait, state: EngineState, conditions: Conditions
) -> Iterator[tuple[EngineState, float]]:
    """Yield states just before an outcome of the wait, each with the time of the outcome.

    In each of them at most one condition has been true all the time, and no other condition has
    been true for long enough.

    Args:
        wait: What waits.
        state: The state in which the wait has just begun.
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
