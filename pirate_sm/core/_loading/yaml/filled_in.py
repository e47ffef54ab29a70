"""Fill in what data still lacks while it is being written, for completion and for snippets.

A model's own errors say what is missing and what is wrong, so no key of any file is named here.
"""

from __future__ import annotations

from typing import Any, Final

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pirate_sm.core._loading.problems import Path
from pirate_sm.core._loading.yaml.error_wording import Schema, SchemaWalk
from pirate_sm.core._loading.yaml.validation import is_echo, part
from pirate_sm.core._model.quantities import FROM_FILE

FILLED: Final = ("x", "$x", "x.x", 1)
"""What stands for a value that is not written yet: a name, a parameter, a code, a number."""

_MOST_ROUNDS: Final = 20
"""Of repairs; a repair may show another error. [decided]"""


def filled_in(model: type[BaseModel], data: Any) -> Any:
    """Return data with what it lacks, and without what is wrong; None if that does not succeed."""
    walk = SchemaWalk(model)
    for _ in range(_MOST_ROUNDS):
        errors = _errors(model, data)
        if not errors:
            return data
        for error in errors:
            data = _repaired(model, walk, data, error)
    return None


def stand_in(walk: SchemaWalk, schema: Schema | None) -> Any:
    """Return what stands for a value of this schema; it may lack something itself."""
    kind = walk.kind(schema or {"type": "any"})
    match kind["type"]:
        case "model-fields" | "dict":
            return {}
        case "list" | "tuple" | "set" | "frozenset":
            return [stand_in(walk, walk.child(kind, 0))]
        case "tagged-union":
            tag, choice = next(iter(kind["choices"].items()))
            return {tag: stand_in(walk, walk.child(walk.kind(choice), tag))}
        case "literal":
            return kind["expected"][0]
        case _:
            return FILLED[0]


def _errors(model: type[BaseModel], data: Any) -> list[ErrorDetails]:
    try:
        model.model_validate(data, context=dict(FROM_FILE), by_alias=True, by_name=False)
    except ValidationError as error:
        return [each for each in error.errors(include_url=False) if not is_echo(each)]
    return []


_NOTHING: Final = object()


def _repaired(model: type[BaseModel], walk: SchemaWalk, data: Any, error: ErrorDetails) -> Any:
    """Return the data without an error; another one may follow from that."""
    trail, kind = walk.follow(error["loc"]), error["type"]
    path, schema = trail.path, trail.schema or {"type": "any"}
    if kind == "missing" and isinstance(_part(data, path[:-1]), dict | list):
        return _put(data, path, stand_in(walk, schema))
    if kind == "missing-key" and isinstance(_part(data, path), dict):
        for key in error["ctx"]["keys"].split():
            data = _put(data, (*path, key), FILLED[0])
        return data
    while (old := _part(data, path)) is _NOTHING:
        path, schema = path[:-1], {"type": "any"}  # another repair has removed it
    new = stand_in(walk, schema)
    if kind == "too_short" and isinstance(old, dict | list):
        first = 0 if isinstance(old, list) else FILLED[0]
        new = stand_in(walk, walk.child(schema, first))
        return _put(data, path, [*old, new] if isinstance(old, list) else {**old, first: new})
    if isinstance(old, dict) and (key := _lacks(model, walk, data, path, error)):
        return _put(data, (*path, key), stand_in(walk, walk.child(schema, key)))
    if old in FILLED[:-1] and not isinstance(new, list | dict):
        return _put(data, path, FILLED[FILLED.index(old) + 1])
    if path and isinstance(path[-1], str) and old != new and not isinstance(new, list | dict):
        rest = part(data, path[:-1])
        return _put(data, path[:-1], {key: rest[key] for key in rest if key != path[-1]})
    return _put(data, path, new) if path else data


def _lacks(
    model: type[BaseModel], walk: SchemaWalk, data: Any, path: Path, error: ErrorDetails
) -> str:
    """Return the key that takes an error away from a mapping; empty without one."""
    schema, fewest = walk.follow(error["loc"]).schema, dict[str, int]()
    for key in walk.fields(schema):
        if schema and key not in _part(data, path):
            trial = _put(data, (*path, key), stand_in(walk, walk.child(schema, key)))
            errors = _errors(model, trial)
            if all((each["loc"], each["type"]) != (error["loc"], error["type"]) for each in errors):
                fewest[key] = len(errors)
    return min(fewest, key=lambda key: fewest[key], default="")


def _part(data: Any, path: Path) -> Any:
    """Return what is written at a path; a text may be short for a list or a mapping."""
    found = data
    for step in path:
        if not isinstance(found, dict | list):
            return _NOTHING
        try:
            found = part(found, (step,))
        except (LookupError, TypeError):
            return _NOTHING
    return found


def _put(data: Any, path: Path, value: Any) -> Any:
    """Return the data with a value at a path, whose last key may be new; the rest is shared."""
    if not path:
        return value
    step, *rest = path
    copy: Any = [*data] if isinstance(data, list) else dict(data)
    copy[step] = _put(copy[step], tuple(rest), value) if rest else value
    return copy
