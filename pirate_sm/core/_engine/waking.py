"""Find when the engine must be called although no event comes."""

from __future__ import annotations

from pirate_sm.core._engine.mission.waiting import next_deadline
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import robot_state
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.state import EngineState


def wake_s(moment: Moment, state: EngineState) -> float:
    """Return the next time at which something changes without an event."""
    due_s = min(deadline_s(moment, state), state.word_until_s)
    if moment.nominal:
        return min(due_s, state.surveyed.due_s)
    return min(due_s, listening_s(moment.robot, state.sensing))


def deadline_s(moment: Moment, state: EngineState) -> float:
    """Return the next deadline of the robot, its mission or the start check."""
    body = state.robot
    if state.mission.suspended:
        body = body._replace(motion=None)  # its deadline is frozen
    due_s = min(
        robot_state.next_deadline(moment.robot, body, moment.nominal), next_deadline(moment, state)
    )
    if state.looking is not None and not state.mission.ending:
        return min(due_s, state.looking.due_s)
    return due_s


def listening_s(robot: RobotSpec, sensing: Sensing) -> float:
    """Return when silent boards and stale signals are looked for again."""
    return sensing.checked_s + robot.link.listen_every_s
