"""The JSON Schema of missions for one robot, with the robot's commands, states and words."""

from __future__ import annotations

from typing import Any

from pirate_sm.core.expressions import EnumType
from pirate_sm.core.loading import LoadedRobot
from pirate_sm.core.robot import USUAL
from pirate_sm.core.units import describe

Schema = dict[str, Any]


def narrowed(mission: Schema, robot: LoadedRobot) -> Schema:
    """Return the schema of missions, restricted to the names of this robot.

    Args:
        mission: The JSON Schema of missions for any robot; it is not modified.
        robot: The robot that provides the names.
    """
    properties, definitions = mission["properties"], mission["definitions"]
    return {
        **mission,
        "title": f"Mission for {robot.profile.robot}",
        "properties": {**properties, "starts_in": _states(properties["starts_in"], robot)},
        "definitions": {
            **definitions,
            "CommandName": _commands(robot),
            "ControlName": _controls(robot),
            "FaultOwner": _owners(robot),
            "Condition": _condition(definitions["Condition"], robot),
            "FaultHandler": _faults(definitions["FaultHandler"], robot),
        },
    }


def _commands(robot: LoadedRobot) -> Schema:
    about = {name: command.description for name, command in robot.profile.commands.items()}
    about |= {alias: f"Another name of {name}." for alias, name in robot.profile.aliases.items()}
    return {
        "type": "string",
        "description": f"A command of {robot.profile.robot}.",
        "enum": list(about),
        "enumDescriptions": list(about.values()),
    }


def _controls(robot: LoadedRobot) -> Schema:
    about = {name: control.description for name, control in robot.profile.controls.items()}
    about[USUAL] = "The robot's default actuation."
    return {
        "type": "string",
        "description": f"A control of {robot.profile.robot}.",
        "enum": list(about),
        "enumDescriptions": list(about.values()),
    }


def _owners(robot: LoadedRobot) -> Schema:
    described = f"A board, joint, wheel or part of {robot.profile.robot}."
    return {"type": "string", "description": described, "enum": [*robot.normal.owners.things]}


def _states(generic: Schema, robot: LoadedRobot) -> Schema:
    regions = zip(robot.table.regions, robot.table.states, strict=True)
    return {
        "type": ["object", "null"],
        "description": generic["description"],
        "properties": {
            region: {"enum": list(states), "description": f"State of {region}."}
            for region, states in regions
        },
        "additionalProperties": False,
    }


def _condition(generic: Schema, robot: LoadedRobot) -> Schema:
    """Return the schema of conditions, with the valid names in its description and examples."""
    lines, examples = [], []
    for name, kind in robot.normal.vocabulary.types.items():
        if isinstance(kind, EnumType):
            lines.append(f"- `{name}`: {', '.join(kind.values)}")
            examples += [f"{name} == {word}" for word in kind.values]
        else:
            lines.append(f"- `{name}`: {describe(kind.dimension)}")
    said = "\n".join([generic["description"], "", "It may name:", *lines])
    return {**generic, "description": said, "examples": examples}


def _faults(generic: Schema, robot: LoadedRobot) -> Schema:
    codes = [rule.code for rule in robot.profile.faults if rule.catchable]
    fault = {**generic["properties"]["fault"], "examples": codes}
    return {**generic, "properties": {**generic["properties"], "fault": fault}}
