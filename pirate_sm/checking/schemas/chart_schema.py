"""The JSON Schema of a chart: the subset of the statechart library's format that is supported.

:mod:`pirate_sm.core.loading` checks the same, and also references and guards, which
a schema cannot check.
"""

from __future__ import annotations

from typing import Any, Final

from pirate_sm.checking.schemas.model_schema import DRAFT
from pirate_sm.core.expressions import KEYWORDS

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
