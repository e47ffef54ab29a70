"""Keys that are equal for states that can only go on alike, and the mishaps before a state."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import isnan
from typing import Any

from pirate_sm.engine.state import EngineState


def key_of(state: EngineState) -> Any:
    """Return what of a state decides how it can go on."""
    mission, body = state.mission, state.robot
    flight, motion = body.flight, body.motion
    if mission.diverting is not None:  # where the fault came up matters no more
        where = mission.diverting.go, mission.diverting.go_name, mission.stopped, mission.handling
        return (
            where,
            body.configuration,
            body.marks,
            body.values,
            body.seeking,
            flight and (flight.purpose, flight.values),
            motion and (motion.command, bool(motion.place), motion.stage, isnan(motion.accepted_s)),
            state.rules,
        )
    return (
        mission.pc,
        mission.begun,
        mission.tries,
        mission.handling,
        mission.result.done if mission.result else None,
        tuple(map(isnan, mission.since)),
        mission.ending and (mission.ending.outcome, mission.ending.end),
        mission.ended,
        body.configuration,
        body.marks,
        body.control,
        body.values,
        body.seeking,
        flight and (flight.purpose, flight.values),
        motion and (motion.command, motion.place, motion.stage, isnan(motion.accepted_s)),
        state.rules,
    )


def key_of_wait(state: EngineState) -> Any:
    """Return the same without regard to which conditions have begun to hold."""
    return key_of(state._replace(mission=state.mission._replace(since=())))


def fewest_mishaps(steps: Sequence[tuple[int, int, bool]]) -> list[int]:
    """Return per node, how many mishaps must have come about before it at least.

    Args:
        steps: Source (-1 before the start) and target of each, and whether it is a mishap.
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
