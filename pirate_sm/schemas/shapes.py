"""JSON Schemas of the constraints between keys that the models' validators check."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from pydantic import BaseModel

from pirate_sm.model.actuation import PostureCase
from pirate_sm.model.mission import End, FaultHandler, Phase, WaitStep
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.safety import SafetyRule

Schema = dict[str, Any]


def _given(key: str) -> Schema:
    """Return the schema that requires the key; in these files `null` counts as absent."""
    return {"required": [key], "properties": {key: {"not": {"type": "null"}}}}


def _without(key: str) -> Schema:
    return {"properties": {key: {"type": "null"}}}


_WAITS: Final[Schema] = {"required": ["wait"], "properties": {"wait": {"minItems": 1}}}
_WAIT_ENDS: Final[Schema] = {
    "properties": {"wait": {"contains": {"type": "object", "required": ["after"]}}}
}
_LEADS: Final[Schema] = {"items": _given("go")}

_NONE: Final[Schema] = {"maxItems": 0, "maxProperties": 0}
"""An empty list or mapping, which counts as absent."""

_OPTIONAL_LEADS: Final[Schema] = {"anyOf": [{"type": "null"}, _given("go")]}

SHAPES: Final[Mapping[type[BaseModel], Schema]] = {
    Pipe: {
        "oneOf": [_given("segments"), _given("runs")],
        "if": _given("runs"),
        "then": {"properties": {"patches": _NONE}},
        "else": {"properties": dict.fromkeys(("junctions", "ends", "routes"), _NONE)},
    },
    Phase: {
        "if": _WAITS,
        "then": {
            "allOf": [
                _without("go"),
                {"anyOf": [_given("within"), _WAIT_ENDS]},
                {"properties": {"wait": _LEADS, "within": _OPTIONAL_LEADS}},
            ]
        },
        "else": {"allOf": [_given("go"), _without("within")]},
    },
    WaitStep: {"if": {"not": _WAIT_ENDS}, "then": _given("within")},
    End: {"oneOf": [_given("succeed"), _given("fail")]},
    PostureCase: {
        "oneOf": [_given("set"), _given("refuse")],
        "if": _given("refuse"),
        "then": {"allOf": [_without("within"), _without("done")]},
    },
    FaultHandler: {"oneOf": [_given("then"), _given("go")]},
    SafetyRule: {
        "oneOf": [_given("always"), _given("never"), _given("expect")],
        "if": _given("expect"),
        "then": {"allOf": [_given("within_steps"), _given("after")]},
        "else": _without("within_steps"),
    },
}
