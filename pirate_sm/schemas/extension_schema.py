"""The JSON Schemas of files that extend others: nothing but the other file is required."""

from __future__ import annotations

from typing import Any, Final

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
