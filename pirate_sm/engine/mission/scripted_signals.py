"""What a script says in the place of sensors, in a run where commands take their nominal time."""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING

from pirate_sm.engine.robot import commands
from pirate_sm.engine.robot.robot_state import Finished
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect, Log
from pirate_sm.model.events import CommandFailed, SignalReport

if TYPE_CHECKING:
    from pirate_sm.engine.engine import Engine

_OUTSIDE = ("detector", "segment")
"""Words that come from outside, in the order in which they end the words of the state."""


def told(
    engine: Engine, state: EngineState, report: SignalReport, effects: list[Effect]
) -> EngineState:
    """Conditions see what the script says; where sensors speak they alone are believed."""
    if not engine.nominal:
        effects.append(Log("warning", "a script cannot say what sensors show that speak"))
        return state
    names = engine.robot.vocabulary.with_changes.numbers
    sensing = state.sensing
    numbers = list(sensing.told or sensing.numbers)
    if any(name.startswith("change(") for name, _ in report.numbers):
        numbers += [nan] * (len(names) - len(numbers))
    for name, value in report.numbers:
        if name in names:
            numbers[names.index(name)] = value
        else:
            effects.append(Log("warning", f"the script says '{name}', an unknown signal"))
    words = list(state.words)
    for name, word in report.words:
        if name in _OUTSIDE:
            words[_OUTSIDE.index(name) - len(_OUTSIDE)] = word
        else:
            effects.append(Log("warning", f"the script says '{name}', which is no word of it"))
    sensing = sensing._replace(told=tuple(numbers))
    return state._replace(sensing=sensing, words=tuple(words))


def undone(
    engine: Engine, state: EngineState, event: CommandFailed, now: float, effects: list[Effect]
) -> EngineState:
    """The command under way has failed as by its timeout, unless its array is still in flight."""
    body = state.robot
    if not engine.nominal or body.motion is None or body.flight is not None:
        effects.append(Log("warning", "no command is under way that a script could let fail"))
        return state
    body = commands.fail(engine.robot, body, event.reason, effects)
    mission = state.mission._replace(result=Finished(False, event.reason))
    return state._replace(robot=body, mission=mission)
