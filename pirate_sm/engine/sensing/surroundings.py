"""Update the pipe around the robot during a run, from outside reports or from its signals."""

from __future__ import annotations

from math import inf

from pirate_sm.engine.deadlines import has_come
from pirate_sm.engine.moment import Moment
from pirate_sm.engine.sensing.environment import NOTHING_AROUND, Surveyed, differs, survey
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Environment
from pirate_sm.model.events import EnvironmentReport


def hear(moment: Moment, state: EngineState, event: EnvironmentReport) -> EngineState:
    """Apply a report from outside; it replaces the robot's own while it is valid."""
    until_s = moment.now_s + event.valid_for_s
    surveyed = state.surveyed._replace(
        outside_until_s=until_s, due_s=min(state.surveyed.due_s, until_s)
    )
    return _changed(moment, state, surveyed, Environment(*event[:4]))


def look_round(moment: Moment, state: EngineState) -> EngineState:
    """Survey the pipe around the robot, and report it if it has changed."""
    if moment.nominal:
        surveyed, found = state.surveyed._replace(due_s=inf), NOTHING_AROUND
    else:
        surveyed, found = survey(
            moment.robot,
            state.surveyed,
            state.robot,
            state.sensing.numbers,
            state.words[-2],
            state.faults.raised,
            moment.now_s,
        )
    if not has_come(moment.now_s, surveyed.outside_until_s):
        return state._replace(surveyed=surveyed)
    if not differs(surveyed.reported, found):
        return state._replace(surveyed=surveyed)
    return _changed(moment, state, surveyed, found)


def _changed(
    moment: Moment, state: EngineState, surveyed: Surveyed, found: Environment
) -> EngineState:
    moment.emit(found)
    words = (*state.words[:-1], found.segment or None)
    return state._replace(words=words, surveyed=surveyed._replace(reported=found))
