"""JSON Schemas of missions, pipes, profiles and charts, for completion and help in editors.

They use draft 7, the newest that yaml-language-server supports, which most editors use.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, Final

from pirate_sm.cli.model_schema import DRAFT, schema_of
from pirate_sm.core.expressions import KEYWORDS, EnumType
from pirate_sm.core.loading import LoadedRobot
from pirate_sm.core.models import Mission, PipeFile, Profile, Twin
from pirate_sm.core.robot import USUAL
from pirate_sm.core.units import describe
from pirate_sm.lab.campaign.campaign_model import Campaign, Scene
from pirate_sm.robot.camera import Camera
from pirate_sm.robot.control_panel.panel_file import Panel

# --- charts --------------------------------------------------------------------------------------
# :mod:`pirate_sm.core.loading` checks the same, and also references and guards, which
# a schema cannot check.


Schema = dict[str, Any]

_NAME: Final = "[A-Za-z][A-Za-z0-9_]{0,63}"
_EVENT: Final = f"^{_NAME}$"
_EVENTS: Final = rf"^\s*{_NAME}(\s+{_NAME})*\s*$"
_WORD: Final = "[A-Za-z_][A-Za-z0-9_]*"
_NO_WORDS: Final = "|".join(sorted(KEYWORDS - {"in"}))
_STATE: Final = rf"^{_WORD}\.(?!(?:{_NO_WORDS})$){_WORD}$"


def chart_schema() -> Schema:
    """Return the JSON Schema of ``chart.yaml``."""
    return {
        "$schema": DRAFT,
        "title": "Statechart of a robot",
        "description": "The state machines of a robot, in python-statemachine's format.",
        **_mapping(
            {
                "name": _text("Name of the chart.", empty=True),
                "description": _text("One-line description.", empty=True),
                "states": {
                    "type": "object",
                    "description": "One parallel state, which holds the state machines.",
                    "minProperties": 1,
                    "maxProperties": 1,
                    "additionalProperties": {"$ref": "#/definitions/parallel"},
                },
            },
            "states",
        ),
        "definitions": {
            "parallel": {
                "description": "The parallel state: all its regions are active together.",
                **_mapping(
                    {
                        "parallel": {"const": True, "description": "Always `true`."},
                        "states": _named("The regions: one state machine each, by name.", "region"),
                    },
                    "parallel",
                    "states",
                ),
            },
            "region": {
                "description": "A state machine.",
                **_mapping(
                    {
                        "states": {
                            **_named("Its states, named `<Region>.<State>`.", "state"),
                            "propertyNames": {"pattern": _STATE},
                        }
                    },
                    "states",
                ),
            },
            "state": _state(),
            "transition": _transition(),
        },
    }


def _state() -> Schema:
    inside = _mapping(
        {
            "initial": {
                "type": "boolean",
                "description": "`true` for the one state that its region, or the state around it, "
                "begins in.",
            },
            "states": {
                **_named("States inside of this one, named `<Region>.<State>` too.", "state"),
                "propertyNames": {"pattern": _STATE},
            },
            "transitions": {
                "type": ["array", "null"],
                "description": "Where events lead from here; the first whose guard is true counts.",
                "items": {"$ref": "#/definitions/transition"},
            },
        }
    )
    return {**inside, "type": ["object", "null"], "description": "A state; it may be empty."}


def _transition() -> Schema:
    return {
        "description": "Where a command leads.",
        **_mapping(
            {
                "event": {
                    "type": ["string", "array"],
                    "pattern": _EVENTS,
                    "items": {"type": "string", "pattern": _EVENT},
                    "minItems": 1,
                    "description": "The command, or several: with spaces between them, or as a "
                    "list. One may move several regions together.",
                },
                "target": _text("The state that it leads to, `<Region>.<State>` of this region."),
                "cond": {
                    **_text(
                        "Guard: `In('Region.State')` with `and`, `or`, `not` and parentheses. "
                        "The quotes matter."
                    ),
                    "examples": ["In('Region.State')", "not In('Region.State')"],
                },
            },
            "event",
            "target",
        ),
    }


def _mapping(properties: Schema, *required: str) -> Schema:
    needed = {"required": list(required)} if required else {}
    return {"type": "object", "properties": properties, **needed, "additionalProperties": False}


def _named(description: str, each: str) -> Schema:
    return {
        "type": "object",
        "description": description,
        "minProperties": 1,
        "additionalProperties": {"$ref": f"#/definitions/{each}"},
    }


def _text(description: str, *, empty: bool = False) -> Schema:
    least = {} if empty else {"pattern": r"\S"}
    return {"type": "string", **least, "description": description}


# --- missions for one robot ----------------------------------------------------------------------


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
    return _one_of(about, f"A command of {robot.profile.robot}.")


def _controls(robot: LoadedRobot) -> Schema:
    about = {name: control.description for name, control in robot.profile.controls.items()}
    about[USUAL] = "The robot's default actuation."
    return _one_of(about, f"A control of {robot.profile.robot}.")


def _one_of(about: Mapping[str, str], description: str) -> Schema:
    """Return the schema of one of the names, each with what editors say about it."""
    names = {"enum": list(about), "enumDescriptions": list(about.values())}
    return {"type": "string", "description": description, **names}


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


# --- files of schemas ----------------------------------------------------------------------------


_MAPS: Final = ("properties", "patternProperties", "definitions")
_LISTS: Final = ("anyOf", "allOf")
_SINGLE: Final = ("items", "additionalProperties")


def extension_of(schema: Schema) -> Schema:
    """Return the schema of a file that extends one of this schema.

    It has the same keys, of which only ``extends`` is required: the rest may be in the other
    file. Conditions on keys (``if``, ``not``, ``oneOf``) may concern the other file too, so they
    are left out.
    """
    loose: Schema = _loosened(schema)
    extends = {
        "type": "string",
        "minLength": 1,
        "description": "The file below this one, relative to the folder of this one.",
    }
    return loose | {
        "title": f"{schema['title']} that extends another one",
        "properties": {"extends": extends, **loose["properties"]},
        "required": ["extends"],
    }


def _loosened(schema: Any) -> Any:
    if not isinstance(schema, dict):
        return schema
    result: Schema = {}
    for key, value in schema.items():
        if key in ("required", "if", "then", "else", "not", "oneOf", "minProperties"):
            continue
        if key in _MAPS:
            result[key] = {name: _loosened(each) for name, each in value.items()}
        elif key in _LISTS:
            result[key] = [_loosened(each) for each in value]
        else:
            result[key] = _loosened(value) if key in _SINGLE else value
    return result


KINDS: Final[Mapping[str, Callable[[], dict[str, Any]]]] = {
    "mission": lambda: schema_of(Mission, "Mission"),
    "pipe": lambda: schema_of(PipeFile, "Pipe"),
    "profile": lambda: schema_of(Profile, "Profile of a robot"),
    "chart": chart_schema,
    "profile_extension": lambda: extension_of(schema_of(Profile, "Profile of a robot")),
    "chart_extension": lambda: extension_of(chart_schema()),
    "camera": lambda: schema_of(Camera, "Camera over the setup"),
    "panel": lambda: schema_of(Panel, "Control panel"),
    "campaign": lambda: schema_of(Campaign, "Campaign"),
    "scene": lambda: schema_of(Scene, "Scene of the gallery"),
    "twin": lambda: schema_of(Twin, "Twin of a robot"),
}
"""The kinds of files that have a schema."""

MODELINE: Final = "# yaml-language-server: $schema="
"""The beginning of a file's first line that names its schema for editors."""


def schema_text(kind: str) -> str:
    """Return the JSON Schema of this kind of file, as text."""
    return _as_file(KINDS[kind]())


def mission_schema_text(robot: LoadedRobot) -> str:
    """Return the JSON Schema of missions for this robot, as text."""
    return _as_file(narrowed(KINDS["mission"](), robot))


def _as_file(schema: dict[str, Any]) -> str:
    return f"{json.dumps(schema, indent=2, ensure_ascii=False)}\n"
