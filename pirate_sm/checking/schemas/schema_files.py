"""The JSON Schemas by kind of file, and their text."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, Final

from pirate_sm.checking.schemas.chart_schema import chart_schema
from pirate_sm.checking.schemas.model_schema import schema_of
from pirate_sm.checking.schemas.robot_mission_schema import narrowed
from pirate_sm.core.camera import Camera
from pirate_sm.core.campaign import Campaign, Scene
from pirate_sm.core.loading import LoadedRobot
from pirate_sm.core.mission import Mission
from pirate_sm.core.panel import Panel
from pirate_sm.core.pipe import PipeFile
from pirate_sm.core.profile import Profile

Schema = dict[str, Any]

_MAPS: Final = ("properties", "patternProperties", "definitions")
_LISTS: Final = ("anyOf", "allOf")
_SINGLE: Final = ("items", "additionalProperties")


def extension_of(schema: Schema) -> Schema:
    """Return the schema of a file that extends one of this schema.

    It has the same keys, of which only ``extends`` is required: the rest may stand in the other
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
}
"""The kinds of files that have a schema."""

MODELINE: Final = "# yaml-language-server: $schema="
"""The beginning of a file's first line that names its schema for editors."""


def schema_text(kind: str) -> str:
    """Return the JSON Schema of this kind of file, as text."""
    return _text(KINDS[kind]())


def mission_schema_text(robot: LoadedRobot) -> str:
    """Return the JSON Schema of missions for this robot, as text."""
    return _text(narrowed(KINDS["mission"](), robot))


def _text(schema: dict[str, Any]) -> str:
    return f"{json.dumps(schema, indent=2, ensure_ascii=False)}\n"
