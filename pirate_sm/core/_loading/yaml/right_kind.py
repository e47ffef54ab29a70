"""Write a value of the wrong kind in the form that its key expects, where only one is meant.

The forms come from the model: a list of one for a list, a mapping with the key that takes the
value for a mapping. The first that the model accepts, but for keys still missing, is the one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice, product
from typing import Any, Final, NamedTuple

import yaml
from pydantic import BaseModel, ValidationError

from pirate_sm.core._loading.idioms import TRIGGER
from pirate_sm.core._loading.problems import Path
from pirate_sm.core._loading.yaml.schema_path import Schema, SchemaWalk
from pirate_sm.core._model.parameters import ParameterDefinition, type_of
from pirate_sm.core._model.quantities import FROM_FILE
from pirate_sm.core.spelling import nearest

_LONGEST: Final = 100
_MOST_TRIED: Final = 30
_QUANTITY: Final = re.compile(r"[-+.]?[0-9][^,]*")
_ITEM: Final = re.compile(r"[^\s:{}\[\]0-9][^\s:{}\[\]]*")  # a name, or a path of a file
_MOST_TEXT: Final = 1_000_000
"""Characters that are validated in search of forms [decided]: about a second."""


def tries(length: int) -> Iterator[int]:
    """Yield once for each form that may be tried in a document of so many characters."""
    return iter(range(max(1, min(100, _MOST_TEXT // max(length, 1)))))


def part(data: Any, path: Path) -> Any:
    """Return the value at a path of plain data."""
    for step in path:
        data = data[step]
    return data


class Form(NamedTuple):
    """How a value is to be written, as YAML; empty if it is not known.

    Attributes:
        line: The value with its key; `…` is what it lacks.
        value: The value alone; empty if it lacks something, or another form fits too.
    """

    line: str = ""
    value: str = ""


def form_of(
    data: Any, path: Path, schema: Schema | None, model: type[BaseModel], left: Iterator[int]
) -> Form:
    """Return how the value at a path is to be written.

    Args:
        data: The whole document.
        path: Path of a value that is of the wrong kind.
        schema: The model's schema of this value.
        model: The model of the document.
        left: The tries that are left for this document.
    """
    if schema is None or not path:
        return Form()
    walk = SchemaWalk(model)
    key, found = path[-1], Form()
    for form, _ in zip(_forms(schema, part(data, path), walk), left, strict=False):
        missing = _missing(model, walk, _with(data, path, form), path)
        if missing is None:
            continue
        if found.line:
            return found._replace(value="")
        whole = {**form, **dict.fromkeys(missing, "…")} if isinstance(form, dict) else form
        line = _flow(whole if isinstance(key, int) else {key: whole})
        if len(line) > _LONGEST:
            return Form()
        found = Form(f"`{line}`", "" if missing else _flow([form])[1:-1])
    return found


def _forms(schema: Schema, value: Any, walk: SchemaWalk) -> Iterator[Any]:
    """Yield what may have been meant by a value, the likelier first."""
    kind = schema["type"]
    if value in ({}, []):
        return  # which says nothing of what was meant
    if kind in ("list", "tuple") and not isinstance(value, list):
        if not isinstance(value, dict):
            yield [{TRIGGER: value}]
        else:
            entries = [_pairs(walk.item(schema), *entry, walk) for entry in value.items()]
            yield from map(list, islice(product(*entries), _MOST_TRIED))
        yield from _items(value)
    elif kind == "model-fields" and isinstance(value, dict) and len(value) == 1:
        yield from _pairs(schema, *next(iter(value.items())), walk)
    elif kind == "model-fields" and not isinstance(value, list | dict):
        if schema["model_name"] == ParameterDefinition.__name__:
            yield {"type": type_of(value), "default": value}
        close = nearest(str(value), walk.fields(schema))
        yield from ({name: value} for name in walk.required(schema) or filter(None, [close]))
    elif isinstance(value, list) and len(value) == 1:
        yield value[0]


def _items(value: Any) -> Iterator[list[Any]]:
    """Yield the lists that a value may be short for: of it alone, or of the parts of a text."""
    if not isinstance(value, str) or _QUANTITY.fullmatch(value):
        yield [value]
        return
    parts = list(filter(None, map(str.strip, value.split(","))))
    words = value.replace(",", " ").split()
    if words and all(map(_ITEM.fullmatch, words)):
        yield words
        if words != parts:
            yield parts  # a text with spaces


def _pairs(schema: Schema | None, key: str, value: Any, walk: SchemaWalk) -> Iterator[Any]:
    """Yield the mappings of two keys that `key: value` may be short for."""
    required = walk.required(schema)
    for name in walk.fields(schema):
        yield from ({first: key, name: value} for first in required if first != name)


def _missing(model: type[BaseModel], walk: SchemaWalk, data: Any, path: Path) -> list[str] | None:
    """Return the keys that a value lacks; None if anything else is wrong in it."""
    try:
        model.model_validate(data, context=dict(FROM_FILE), by_alias=True, by_name=False)
    except ValidationError as error:
        missing = []
        for each in error.errors(include_url=False):
            found = walk.follow(each["loc"]).path
            if found[: len(path)] != path:
                continue
            if each["type"] == "missing" and found[:-1] == path:
                missing.append(str(found[-1]))
            elif each["type"] == "missing-key" and found == path:
                missing += each.get("ctx", {}).get("keys", "").split()
            else:
                return None
        return missing
    return []


def _with(data: Any, path: Path, value: Any) -> Any:
    """Return the data with another value at a path; the rest is shared."""
    if not path:
        return value
    step, *rest = path
    copy: Any = list(data) if isinstance(data, list) else dict(data)
    copy[step] = _with(data[step], tuple(rest), value)
    return copy


def _flow(value: Any) -> str:
    """Return a value as one line of YAML; a mapping of one key as `key: value`."""
    text = yaml.safe_dump(
        value, default_flow_style=True, width=float("inf"), allow_unicode=True, sort_keys=False
    )
    line = text.removesuffix("\n...\n").strip()
    return line[1:-1] if isinstance(value, dict) and len(value) == 1 else line
