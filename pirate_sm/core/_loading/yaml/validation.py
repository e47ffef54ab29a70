"""Validate plain data, and convert pydantic's errors to problems with their places.

A value of the wrong kind is written in the form that its key expects, where only one is meant. The
forms come from the model: a list of one for a list, a mapping with the key that takes the value
for a mapping. The first that the model accepts, but for keys still missing, is the one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice, product
from typing import Any, Final, NamedTuple, TypeVar

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pirate_sm.core._loading.problems import TRIGGER, Path, Problems, meant_key
from pirate_sm.core._loading.yaml.document import Document
from pirate_sm.core._loading.yaml.error_wording import (
    Schema,
    SchemaTrail,
    SchemaWalk,
    Wording,
    merged,
    misspelt_kind,
    wanted_kind,
    word,
)
from pirate_sm.core._model.mission import ParameterDefinition, type_of
from pirate_sm.core._model.quantities import FROM_FILE
from pirate_sm.core.spelling import nearest, one_of

M = TypeVar("M", bound=BaseModel)
_MOST_ERRORS = 200
_UNKNOWN_KEY = ("extra_forbidden", "unexpected_keyword_argument")
_MISSING_KEY = ("missing", "missing_argument", "missing_keyword_only_argument")


def validate(document: Document, model: type[M]) -> M:
    """Return the model that a document describes.

    Args:
        document: The file.
        model: A pydantic model.

    Raises:
        LoadError: The document is invalid; holds all faults.
    """
    problems = Problems(document)
    result = try_validate(document, model, problems)
    problems.raise_errors()
    assert result is not None
    return result


def try_validate(document: Document, model: type[M], problems: Problems, at: Path = ()) -> M | None:
    """Return the model that a document describes, or None after reporting its faults."""
    data = part(document.data, at)
    try:
        # In a file a field has only its alias as its name, if it has one.
        return model.model_validate(data, context=dict(FROM_FILE), by_alias=True, by_name=False)
    except ValidationError as error:
        walk = SchemaWalk(model)
        details = [detail for detail in error.errors(include_url=False) if not is_echo(detail)]
        errors = [_Error(detail, walk.follow(detail["loc"])) for detail in details[:_MOST_ERRORS]]
        relevant = _relevant(errors, walk)
        misspelt = {
            _meant(error, walk) for error in relevant if error.detail["type"] in _UNKNOWN_KEY
        }
        about = problems.about(document)
        left = tries(len(document.text))
        for kept in relevant:
            # Do not report a misspelt key as missing too.
            if kept.detail["type"] not in _MISSING_KEY or kept.trail.path not in misspelt:
                _report(_with_form(kept, data, model, left), walk, about, at)
        if len(details) > _MOST_ERRORS:
            about.add("more", at, f"{len(details) - _MOST_ERRORS} more errors are not shown")
        return None


def _with_form(error: _Error, data: Any, model: type[BaseModel], left: Iterator[int]) -> _Error:
    """Return an error about a wrong kind of value with the right form, if it is clear."""
    wording, path = error.worded(), error.trail.path
    if error.detail["type"] in _UNKNOWN_KEY and path[:-1] and len(part(data, path[:-1])) == 1:
        parent = SchemaWalk(model).parent(error.detail["loc"])
        form = _form_of(data, path[:-1], parent, model, left)  # the key may stand for a value
        return replace(error, wording=wording._replace(expected=form.line))
    if wording.code != "kind" or wording.expected or wording.suggestion:
        return error
    form = _form_of(data, path, error.trail.schema, model, left)
    return replace(error, wording=wording._replace(expected=form.line, write=form.value))


def is_echo(detail: ErrorDetails) -> bool:
    """Return whether a list is only reported as too short because its entries are faulty."""
    minimum = detail.get("ctx", {}).get("min_length", 0)
    return detail["type"] == "too_short" and len(detail["input"]) >= minimum


def _meant(error: _Error, walk: SchemaWalk) -> Path:
    """Return the path of an unknown key, with the key replaced by the nearest known one."""
    *parents, key = error.trail.path
    fields = walk.fields(walk.parent(error.detail["loc"]))
    return (*parents, meant_key(str(key), fields) or key)


@dataclass(frozen=True, slots=True)
class _Error:
    """One error with its trail; `wording` replaces its message if errors were merged."""

    detail: ErrorDetails
    trail: SchemaTrail
    wording: Wording | None = None

    def worded(self) -> Wording:
        """Return the message."""
        return self.wording or word(self.detail, self.trail.schema)


def _relevant(errors: list[_Error], walk: SchemaWalk) -> list[_Error]:
    """Return the errors without those of union branches that were not meant."""
    kept = [error for error in errors if not error.trail.branches]
    unions: dict[Path, dict[str, list[_Error]]] = {}
    for error in errors:
        if error.trail.branches:
            (point, label), *inner = error.trail.branches
            stripped = replace(error, trail=replace(error.trail, branches=tuple(inner)))
            unions.setdefault(point, {}).setdefault(label, []).append(stripped)
    for point, branches in unions.items():
        relevant = [_relevant(branch, walk) for branch in branches.values()]
        kept += _best_branch(point, relevant, walk)
    return kept


def _best_branch(point: Path, branches: list[list[_Error]], walk: SchemaWalk) -> list[_Error]:
    """Return the errors of the branch that was most likely meant.

    Branches for another kind of value are excluded. Of the others, the branch with the fewest
    errors is chosen, where a misspelt key counts less than an unknown key.
    """
    meant = [
        branch
        for branch in branches
        if not any(error.trail.path == point and wanted_kind(error.detail) for error in branch)
    ]
    if meant:
        return min(meant, key=lambda branch: len(branch) - _misspelt(branch, walk))
    first = branches[0][0]
    kinds = [wanted_kind(error.detail) for branch in branches for error in branch]
    wording = merged([kind for kind in kinds if kind], first.detail["input"])
    return [replace(first, wording=wording)]


def _misspelt(errors: list[_Error], walk: SchemaWalk) -> int:
    """Return the number of errors that are misspelt keys."""
    unknown = [error for error in errors if error.detail["type"] in _UNKNOWN_KEY]
    return sum(_meant(error, walk) != error.trail.path for error in unknown)


def _report(error: _Error, walk: SchemaWalk, problems: Problems, at: Path) -> None:
    """Add one error to the problems."""
    kind, path = error.detail["type"], (*at, *error.trail.path)
    if kind in _UNKNOWN_KEY:
        _report_unknown_key(error, walk, problems, path)
    elif kind in _MISSING_KEY:
        short = isinstance(path[-1], int)
        message = "the list is too short" if short else f"the key '{path[-1]}' is missing"
        only = (error.trail.schema or {}).get("expected", ())
        expected = f"`{path[-1]}: {only[0]}`" if len(only) == 1 else ""
        problems.add("missing-key", path[:-1], message, expected=expected, key=True)
    else:
        code, message, expected, suggestion, write = error.worded()
        # Show a fault of a whole mapping at its key.
        key = error.trail.key or isinstance(error.detail["input"], dict)
        if kind == "key":
            path = (*path, *_last_key(error.detail))
        if kind == "union_tag_invalid":
            path, key = (*path, _discriminator(error.detail)), False
        if misspelt := misspelt_kind(error.detail, error.trail.schema):
            path = (*path, misspelt[0])
        problems.add(
            code, path, message, expected=expected, suggestion=suggestion, write=write, key=key
        )


def _last_key(detail: ErrorDetails) -> Path:
    """Return the last key in the file of those that a fault is about; none if none is there."""
    keys = detail.get("ctx", {}).get("keys", "").split()
    written = detail["input"] if isinstance(detail["input"], dict) else {}
    return tuple(key for key in written if key in keys)[-1:]


def _discriminator(detail: ErrorDetails) -> str:
    return str(detail.get("ctx", {}).get("discriminator", "")).strip("'")


def _report_unknown_key(error: _Error, walk: SchemaWalk, problems: Problems, path: Path) -> None:
    key = str(path[-1])
    fields = walk.fields(walk.parent(error.detail["loc"]))
    expected = error.worded().expected or (one_of(fields) if fields else "")
    if key.endswith(")") or "(" in key:
        expected = "text with commas in quotes: inside { } a comma ends it"
    if key[:1].isdigit():
        expected = "a point in numbers, as in 0.2 m: inside { } a comma ends a value"
    problems.add(
        "unknown-key",
        path,
        f"unknown key '{key}'",
        expected=expected,
        suggestion=meant_key(key, fields),
        key=True,
    )


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


class _Form(NamedTuple):
    """How a value is to be written, as YAML; empty if it is not known.

    Attributes:
        line: The value with its key; `…` is what it lacks.
        value: The value alone; empty if it lacks something, or another form fits too.
    """

    line: str = ""
    value: str = ""


def _form_of(
    data: Any, path: Path, schema: Schema | None, model: type[BaseModel], left: Iterator[int]
) -> _Form:
    """Return how the value at a path is to be written.

    Args:
        data: The whole document.
        path: Path of a value that is of the wrong kind.
        schema: The model's schema of this value.
        model: The model of the document.
        left: The tries that are left for this document.
    """
    if schema is None or not path:
        return _Form()
    walk = SchemaWalk(model)
    key, found = path[-1], _Form()
    for form, _ in zip(_forms(schema, part(data, path), walk), left, strict=False):
        missing = _missing(model, walk, _with(data, path, form), path)
        if missing is None:
            continue
        if found.line:
            return found._replace(value="")
        whole = {**form, **dict.fromkeys(missing, "…")} if isinstance(form, dict) else form
        line = _flow(whole if isinstance(key, int) else {key: whole})
        if len(line) > _LONGEST:
            return _Form()
        found = _Form(f"`{line}`", "" if missing else _flow([form])[1:-1])
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
