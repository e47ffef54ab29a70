"""Check the call of a mission, and evaluate its arguments."""

from __future__ import annotations

from pirate_sm.loading.mission import parameter_values as parameters
from pirate_sm.loading.mission.called_missions import suits
from pirate_sm.loading.mission.parameter_values import Values
from pirate_sm.loading.mission.scope import Scope, Source
from pirate_sm.loading.problems import Path
from pirate_sm.model import mission as model


def arguments_of(step: model.CallStep, source: Source, scope: Scope, path: Path) -> Values:
    """Return the values of the parameters of a called mission."""
    mission = source.mission
    at = (*path, "with")
    values = parameters.defaults(mission.parameters, scope.problems.about(source.document))
    given = {name: scope.argument(v, (*at, name)) for name, v in step.arguments.items()}
    values |= parameters.given(mission.parameters, given, at, scope.problems)
    for name in mission.parameters.keys() - values.keys():
        values[name] = parameters.stand_in(mission.parameters[name])
        scope.problems.add(
            "mission.parameter", path, f"'{mission.mission}' needs the parameter '{name}'"
        )
    return values


def check_call(source: Source, scope: Scope, path: Path) -> bool:
    """Return whether a called mission is for this robot, or report why it is not.

    A mission for a robot that this one extends is: it has all of its states and commands.
    """
    mission, own = source.mission, scope.source
    polarity = scope.robot.polarity
    if mission.polarity not in {None, polarity}:
        message = f"'{mission.mission}' is {mission.polarity}, this mission is {polarity}"
        scope.problems.add("mission.polarity", path, message)
    if not suits(source, own):
        message = f"'{mission.mission}' is for the robot '{mission.robot}'"
        scope.problems.add("mission.robot", path, message)
        return False
    return True
