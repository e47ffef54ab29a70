"""Keys for equivalent states of an exploration, and the number of mishaps before a state."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import isnan
from typing import Any

from pirate_sm.engine.state import EngineState


def key_of(state: EngineState) -> Any:
    """Return a key that is equal for states that can only continue in the same way."""
    mission, body = state.mission, state.robot
    flight, motion = body.flight, body.motion
    robot = (
        (body.configuration, body.marks, body.values, body.seeking),
        flight and (flight.purpose, flight.values),
        motion and (motion.command, motion.stage, isnan(motion.accepted_s)),
        state.rules,
    )
    if mission.diverting is not None:  # the place of the fault is irrelevant now
        where = mission.diverting.go, mission.diverting.go_name, mission.stopped, mission.handling
        return where, motion and bool(motion.place), robot
    return (
        (mission.pc, mission.begun, mission.tries, mission.handling, mission.ended),
        mission.result.done if mission.result else None,
        tuple(map(isnan, mission.since)),
        mission.ending and (mission.ending.outcome, mission.ending.end),
        motion and motion.place,
        robot,
    )


def key_of_wait(state: EngineState) -> Any:
    """Return the same key, independent of the conditions that have become true."""
    return key_of(state._replace(mission=state.mission._replace(since=())))


def fewest_mishaps(steps: Sequence[tuple[int, int, bool]]) -> list[int]:
    """Return for each state the smallest number of mishaps before it.

    Args:
        steps: For each step its source (-1 before the start), target, and whether it is a mishap.
    """
    after: dict[int, list[tuple[int, bool]]] = {}
    fewest = [len(steps)] * (1 + max(target for _, target, _ in steps))
    waiting: deque[int] = deque()
    for source, target, mishap in steps:
        if source < 0:
            fewest[target] = 0
            waiting.append(target)
        else:
            after.setdefault(source, []).append((target, mishap))
    while waiting:
        node = waiting.popleft()
        for target, mishap in after.get(node, ()):
            if fewest[node] + mishap < fewest[target]:
                fewest[target] = fewest[node] + mishap
                (waiting.append if mishap else waiting.appendleft)(target)
    return fewest
