"""Signals from a script in place of sensors, in runs where commands take their nominal time."""

from __future__ import annotations

from math import nan

from pirate_sm.engine.moment import Moment
from pirate_sm.engine.robot import commands
from pirate_sm.engine.robot.robot_state import Finished
from pirate_sm.engine.state import EngineState
from pirate_sm.model.events import CommandFailed, SignalReport

_OUTSIDE = ("detector", "segment")
"""Names of the last words of the state, which come from outside, in their order."""


def show(moment: Moment, state: EngineState, report: SignalReport) -> EngineState:
    """Set the signals that conditions see to those of the script; refuse that on real sensors."""
    if not moment.nominal:
        moment.warn("a script cannot say what sensors show that speak")
        return state
    names = moment.robot.vocabulary.with_changes.numbers
    sensing = state.sensing
    numbers = list(sensing.told or sensing.numbers)
    if any(name.startswith("change(") for name, _ in report.numbers):
        numbers += [nan] * (len(names) - len(numbers))
    for name, value in report.numbers:
        if name in names:
            numbers[names.index(name)] = value
        else:
            moment.warn(f"the script says '{name}', an unknown signal")
    words = list(state.words)
    for name, word in report.words:
        if name in _OUTSIDE:
            words[_OUTSIDE.index(name) - len(_OUTSIDE)] = word
        else:
            moment.warn(f"the script says '{name}', which is no word of it")
    sensing = sensing._replace(told=tuple(numbers))
    return state._replace(sensing=sensing, words=tuple(words))


def fail_command(moment: Moment, state: EngineState, event: CommandFailed) -> EngineState:
    """End the command under way as timed out, unless its array is still in flight."""
    body = state.robot
    if not moment.nominal or body.motion is None or body.awaited is not None:
        moment.warn("no command is under way that a script could let fail")
        return state
    body = commands.fail(moment, body, event.reason)
    mission = state.mission._replace(result=Finished(False, event.reason))
    return state._replace(robot=body, mission=mission)
