"""Generate the JSON Schema of a model, with descriptions and what its validators check."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from typing import Any, Final

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import core_schema

from pirate_sm.core.fields import DEFINED, QUANTITY
from pirate_sm.core.models import (
    DetectorDefinition,
    End,
    FaultHandler,
    Phase,
    Pipe,
    PostureCase,
    SafetyRule,
    WaitStep,
)

_ATTRIBUTE = re.compile(r"    (\w+): (.*)")


def summary(model: type[BaseModel]) -> str:
    """Return the docstring's description of the model, as Markdown."""
    return _markdown(_parts(model)[0])


def explanations(model: type[BaseModel]) -> dict[str, str]:
    """Return the docstring's description of each field, including inherited ones, as Markdown."""
    found: dict[str, str] = {}
    for each in reversed(model.__mro__):
        if issubclass(each, BaseModel):
            found |= _attributes(_parts(each)[1])
    return {name: _markdown(text) for name, text in found.items()}


def _parts(model: type[BaseModel]) -> tuple[str, str]:
    text = inspect.cleandoc(model.__dict__.get("__doc__") or "")
    head, _, attributes = text.partition("Attributes:\n")
    return head.strip(), attributes


def _attributes(section: str) -> dict[str, str]:
    found: dict[str, str] = {}
    name = ""
    for line in section.splitlines():
        match = _ATTRIBUTE.match(line)
        if match is not None:
            name = match[1]
            found[name] = match[2]
        elif name:
            found[name] += f" {line.strip()}"
    return found


def _markdown(text: str) -> str:
    paragraphs = [" ".join(part.split()) for part in text.split("\n\n")]
    return "\n\n".join(paragraphs).replace("``", "`").strip()


Schema = dict[str, Any]

DRAFT: Final = "http://json-schema.org/draft-07/schema#"

_TEXTS: Final[dict[str, Schema]] = {
    "Condition": {
        "type": "string",
        "description": (
            "A condition such as `speed < 5 mm/s and segment == Joint`: signals, states and "
            "quantities with comparisons, arithmetic, `and`, `or`, `not`."
        ),
    },
    "CommandName": {
        "type": "string",
        "description": "A command of the robot; short for `{command: …}`.",
    },
    "ControlName": {
        "type": "string",
        "description": "A control of the robot, or `none` for its default actuation.",
    },
    "FaultOwner": {
        "type": "string",
        "description": "A board (`board_26`), joint, wheel or part of the robot.",
    },
}
"""Kinds of text that a robot's own schema restricts."""

_MAPS: Final = ("properties", "patternProperties", "definitions")
_LISTS: Final = ("anyOf", "oneOf", "allOf")
_SINGLE: Final = ("items", "additionalProperties", "contains", "not", "if", "then", "else")
_NULL: Final = {"type": "null"}


def schema_of(model: type[BaseModel], title: str) -> Schema:
    """Return the JSON Schema of a file that contains one such model."""
    raw = model.model_json_schema(
        ref_template="#/definitions/{model}", schema_generator=_Explaining
    )
    tidy = _Tidy()
    definitions = tidy.within("definitions", raw.pop("$defs", {}) | _TEXTS)
    schema = tidy.schema(raw)
    found = definitions | tidy.quantities
    return {
        "$schema": DRAFT,
        "title": title,
        **schema,
        "definitions": {name: found[name] for name in sorted(_used(schema, found))},
    }


class _Explaining(GenerateJsonSchema):
    """Generates schemas with descriptions from docstrings and the constraints of validators."""

    def model_schema(self, schema: core_schema.ModelSchema) -> Schema:
        """Return the model's schema, with descriptions of the model and its keys."""
        result = super().model_schema(schema)
        model = schema["cls"]
        model.model_rebuild()  # its fields are complete only once it was built itself
        said = explanations(model)
        for name, field in model.model_fields.items():
            node = result["properties"][field.alias or name]
            sentences = (said.get(name, ""), _taken_description(node))
            node["description"] = " ".join(sentence for sentence in sentences if sentence)
        result["description"] = summary(model)
        for base in reversed(model.__mro__):
            result |= SHAPES.get(base, {})
        return result

    def tagged_union_schema(self, schema: core_schema.TaggedUnionSchema) -> Schema:
        """Return an ``anyOf`` of the choices: each has a key of its own, so only one can match."""
        result = super().tagged_union_schema(schema)
        result.pop("discriminator", None)
        return {"anyOf": result.pop("oneOf"), **result}

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> Schema:
        """Return the schema with its default, unless the default is null or empty."""
        result = super().default_schema(schema)
        if "$ref" in result or result.get("default") in (None, "", [], {}):
            result.pop("default", None)
        return result


def _taken_description(node: Schema) -> str:
    """Remove and return the description of the kind of value inside a choice."""
    holders = [node, *node.get("anyOf", [])]
    said = [str(each.pop("description")) for each in holders if "description" in each]
    return said[0] if said else ""


class _Tidy:
    """Converts pydantic's schema into a shorter draft 7 schema that is readable in editors.

    Attributes:
        quantities: The schema of each kind of quantity, by name.
    """

    def __init__(self) -> None:
        self.quantities: dict[str, Schema] = {}

    def schema(self, node: Any) -> Any:
        """Return the schema with all nested schemas converted."""
        if not isinstance(node, dict):
            return node
        inner = {key: self.within(key, value) for key, value in node.items() if key != "title"}
        if "default" in inner:
            inner["default"] = _written_default(node)
        if DEFINED in inner:
            inner["$ref"] = _reference(inner.pop(DEFINED))
        if QUANTITY in inner:
            inner = self._quantity(inner)
        if "patternProperties" in inner:
            inner.setdefault("additionalProperties", False)
        inner = _merged(inner)
        if "$ref" in inner and len(inner) > 1:
            # Draft 7 ignores all keys next to a reference.
            inner = {"allOf": [{"$ref": inner.pop("$ref")}], **inner}
        return inner

    def within(self, key: str, value: Any) -> Any:
        """Return the value of a schema's key with all schemas in it converted."""
        if key in _MAPS:
            return {name: self.schema(each) for name, each in value.items()}
        if key in _LISTS:
            return [self.schema(each) for each in value]
        return self.schema(value) if key in _SINGLE else value

    def _quantity(self, node: Schema) -> Schema:
        """Return the node with its long pattern replaced by a reference to a single definition."""
        name = node[QUANTITY]["name"]
        body = {key: node[key] for key in ("type", "pattern", "patternErrorMessage")}
        known = self.quantities.setdefault(name, body)
        assert known == body, f"two patterns are named {name}"
        rest = {key: value for key, value in node.items() if key not in body and key != QUANTITY}
        return {"$ref": _reference(name), **rest}


def _written_default(node: Schema) -> Any:
    """Return the default as written in a file: a quantity with its unit."""
    default = node["default"]
    for each in [node, *node.get("anyOf", [])]:
        unit = each.get(QUANTITY, {}).get("unit", "")
        if unit and isinstance(default, float):
            return f"{default:g} {unit}"
    return default


def _merged(node: Schema) -> Schema:
    """Return the node with nested choices flattened, and plain types merged."""
    if "anyOf" not in node:
        return node
    choices: list[Schema] = []
    examples: list[Any] = []
    for choice in node["anyOf"]:
        inside = choice.get("anyOf", []) if choice.keys() <= {"anyOf", "examples"} else []
        choices += inside or [choice]
        examples = choice.get("examples", []) if inside else examples
    rest = {key: value for key, value in node.items() if key != "anyOf"}
    if examples:
        rest.setdefault("examples", examples)
    if all(choice.keys() == {"type"} for choice in choices):
        types = [choice["type"] for choice in choices]
        kept = [each for each in types if each != "integer" or "number" not in types]
        return {"type": kept, **rest}
    first, *others = choices
    if others == [_NULL] and isinstance(first.get("type"), str) and "enum" not in first:
        return {**first, "type": [first["type"], "null"], **rest}
    return {"anyOf": choices, **rest}


def _reference(name: str) -> str:
    return f"#/definitions/{name}"


def _used(schema: Any, definitions: dict[str, Schema]) -> set[str]:
    """Return the names of the definitions that the schema refers to, directly or indirectly."""
    used: set[str] = set()
    left = [schema]
    while left:
        node = left.pop()
        if isinstance(node, dict):
            reference = node.get("$ref")
            name = reference.rpartition("/")[2] if isinstance(reference, str) else None
            if name is not None and name not in used:
                used.add(name)
                left.append(definitions[name])
            left += node.values()
        elif isinstance(node, list):
            left += node
    return used


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
    DetectorDefinition: {
        "if": _given("forward"),
        "then": _given("backward"),
        "else": {"allOf": [_without("backward"), _given("when")]},
    },
    SafetyRule: {
        "oneOf": [_given("always"), _given("never"), _given("expect")],
        "if": _given("expect"),
        "then": {"allOf": [_given("within_steps"), _given("after")]},
        "else": _without("within_steps"),
    },
}
