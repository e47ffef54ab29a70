"""Update the pipe around the robot during a run, from outside reports or from its signals."""

from __future__ import annotations

from math import inf

from pirate_sm.core._engine.deadlines import has_come
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.sensing.environment import survey
from pirate_sm.core._engine.sensing.environment_report import NOTHING_AROUND, differs, merged
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._model.effects import Environment
from pirate_sm.core._model.events import EnvironmentReport


def hear(moment: Moment, state: EngineState, event: EnvironmentReport) -> EngineState:
    """Take a report from outside in; what it knows counts while it is valid."""
    said = event._asdict()
    until_s = moment.now_s + said.pop("valid_for_s")
    surveyed = state.surveyed._replace(
        outside=Environment(**said), outside_until_s=until_s, due_s=moment.now_s
    )
    return state._replace(surveyed=surveyed)


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
            state.outside("detector"),
            state.faults.raised,
            moment.now_s,
        )
    if not has_come(moment.now_s, surveyed.outside_until_s):
        found = merged(found, surveyed.outside)
        surveyed = surveyed._replace(due_s=min(surveyed.due_s, surveyed.outside_until_s))
    if not differs(surveyed.reported, found):
        return state._replace(surveyed=surveyed)
    moment.emit(found)
    heard = state.hearing(segment=found.segment or None, joint=found.joint or None)
    return heard._replace(surveyed=surveyed._replace(reported=found))
