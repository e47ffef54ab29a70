"""Translate pydantic's errors into messages for authors of YAML files, with the path in the file.

The location of an error also contains labels of unions (`steps.0.CallStep.with`), which look like
keys. The schema that pydantic compiled for the model is followed in parallel to distinguish them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple, TypeAlias, get_args

from pydantic import BaseModel, StringConstraints
from pydantic_core import ErrorDetails

from pirate_sm.core._loading.problems import Path, meant_key, step_form
from pirate_sm.core._loading.yaml.composer import ScalarError, resolve_plain
from pirate_sm.core._model.base import Date, FaultCode, Name
from pirate_sm.core._model.pipe_runs import Port
from pirate_sm.core._model.robot.signals import TypeName
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.core.units import QuantityError, in_unit_of

Schema: TypeAlias = Mapping[str, Any]
Location: TypeAlias = tuple[str | int, ...]

_WRAPPERS = {
    "default": "schema",
    "nullable": "schema",
    "function-before": "schema",
    "function-after": "schema",
    "function-wrap": "schema",
    "model": "schema",
    "dataclass": "schema",
    "lax-or-strict": "lax_schema",
    "json-or-python": "python_schema",
}


@dataclass(frozen=True, slots=True)
class SchemaTrail:
    """The resolved location of an error.

    Attributes:
        path: Keys and indexes in the data, without labels.
        schema: The model's schema of the value; None if it has none.
        branches: The branches of untagged unions on the way: the union's path and the label.
        key: Whether the error concerns the last key and not its value.
    """

    path: Path = ()
    schema: Schema | None = None
    branches: tuple[tuple[Path, str], ...] = ()
    key: bool = False


class SchemaWalk:
    """Follows locations through the schema of one model."""

    def __init__(self, model: type[BaseModel]) -> None:
        schema: Schema = model.__pydantic_core_schema__
        self._definitions: dict[str, Schema] = {}
        if schema["type"] == "definitions":
            self._definitions = {entry["ref"]: entry for entry in schema["definitions"]}
            schema = schema["schema"]
        self._root = schema

    def follow(self, location: Location) -> SchemaTrail:
        """Return the trail of a location, as far as the schema covers it."""
        return self._follow(self._root, location, ())

    def fields(self, schema: Schema | None) -> tuple[str, ...]:
        """Return the keys that a mapping of this schema may have; empty if it allows any key."""
        if schema is None or schema["type"] not in ("model-fields", "dataclass-args"):
            return ()
        return tuple(name for name, _ in self._named_fields(schema))

    def required(self, schema: Schema | None) -> tuple[str, ...]:
        """Return the keys that a mapping of this schema must have."""
        if not self.fields(schema):
            return ()
        assert schema is not None
        return tuple(name for name, each in self._named_fields(schema) if each["type"] != "default")

    def item(self, schema: Schema) -> Schema | None:
        """Return the schema of a list's items."""
        found = self.child(schema, 0)
        return self._plain(found) if found else None

    def parent(self, location: Location) -> Schema | None:
        """Return the schema of the mapping that contains a location's last key."""
        return self.follow(location[:-1]).schema

    def kind(self, schema: Schema) -> Schema:
        """Return the schema of what is usually written: of a union's first, short for a mapping."""
        while True:
            if schema["type"] == "definition-ref":
                schema = self._definitions[schema["schema_ref"]]
            elif schema["type"] == "union":
                first = schema["choices"][0]
                schema = first[0] if isinstance(first, tuple) else first
            elif schema["type"] in _WRAPPERS and schema["type"] != "function-before":
                schema = schema[_WRAPPERS[schema["type"]]]
            else:
                return schema

    def _plain(self, schema: Schema) -> Schema:
        """Return the schema inside references, validators, defaults and other wrappers."""
        while True:
            kind = schema["type"]
            if kind == "definition-ref" and schema["schema_ref"] in self._definitions:
                schema = self._definitions[schema["schema_ref"]]
            elif kind == "chain":
                schema = schema["steps"][0]
            elif kind in _WRAPPERS:
                schema = schema[_WRAPPERS[kind]]
            else:
                return schema

    def _follow(self, schema: Schema, location: Location, path: Path) -> SchemaTrail:
        schema = self._plain(schema)
        if not location:
            return SchemaTrail(path, schema)
        part, rest = location[0], location[1:]
        match schema["type"]:
            case "tagged-union":
                choice = self._choice(schema, part)
                return self._follow(choice, rest, path) if choice else SchemaTrail(path, schema)
            case "union":
                return self._branch(schema, str(part), rest, path)
            case _:
                child = self.child(schema, part)
        if rest == ("[key]",):
            return SchemaTrail((*path, part), None, key=True)
        if child is None:
            return SchemaTrail((*path, part))
        return self._follow(child, rest, (*path, part))

    def _choice(self, schema: Schema, tag: str | int) -> Schema | None:
        for name, choice in schema["choices"].items():
            if str(getattr(name, "value", name)) == str(tag):
                found: Schema = choice
                return found
        return None

    def _branch(self, schema: Schema, label: str, rest: Location, path: Path) -> SchemaTrail:
        """Return the trail through the branch with this label, or the longest trail."""
        choices = [
            (choice[0], choice[1]) if isinstance(choice, tuple) else (choice, None)
            for choice in schema["choices"]
        ]
        labelled = [choice for choice, tag in choices if self._label(choice, tag) == label]
        candidates = labelled or [choice for choice, _ in choices]
        trails = [self._follow(choice, rest, path) for choice in candidates]
        best = max(trails, key=lambda trail: (trail.schema is not None, len(trail.path)))
        return replace(best, branches=((path, label), *best.branches))

    def _label(self, choice: Schema, tag: str | None) -> str | None:
        """Return the label of a branch: a tag or a class name; None if unknown."""
        if tag is not None:
            return tag
        while choice["type"] in _WRAPPERS or choice["type"] == "definition-ref":
            if choice["type"] in ("model", "dataclass"):
                return str(choice["cls"].__name__)
            if choice["type"] == "definition-ref":
                if choice["schema_ref"] not in self._definitions:
                    return None
                choice = self._definitions[choice["schema_ref"]]
            else:
                choice = choice[_WRAPPERS[choice["type"]]]
        return None

    def child(self, schema: Schema, part: str | int) -> Schema | None:
        """Return the schema of the value at a key or index, with its wrappers."""
        found: Schema | None = None
        match schema["type"]:
            case "model-fields" | "dataclass-args":
                found = dict(self._named_fields(schema)).get(str(part))
            case "dict":
                found = schema.get("values_schema")
            case "list" | "set" | "frozenset":
                found = schema.get("items_schema")
            case "tuple" if isinstance(part, int):
                items = schema["items_schema"]
                variadic = schema.get("variadic_item_index", len(items))
                found = items[min(part, variadic, len(items) - 1)] if items else None
        return found

    @staticmethod
    def _named_fields(schema: Schema) -> Iterator[tuple[str, Schema]]:
        """Yield each field with its name in files."""
        if schema["type"] == "dataclass-args":
            for entry in schema["fields"]:
                yield str(entry.get("validation_alias", entry["name"])), entry["schema"]
            return
        for name, entry in schema["fields"].items():
            yield str(entry.get("validation_alias", name)), entry["schema"]


class Wording(NamedTuple):
    """The message for an error; `write` is the value, as YAML, that alone can be meant."""

    code: str
    message: str
    expected: str = ""
    suggestion: str = ""
    write: str = ""


# The expected kind of value, by the type of pydantic's error.
_WANTED: Final = {
    **dict.fromkeys(
        ("model_type", "model_attributes_type", "dict_type", "mapping_type", "dataclass_type"),
        "a mapping",
    ),
    **dict.fromkeys(
        ("list_type", "tuple_type", "set_type", "frozen_set_type", "iterable_type"), "a list"
    ),
    **dict.fromkeys(("string_type",), "text"),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float"), "a whole number"),
    **dict.fromkeys(("float_type", "float_parsing"), "a number"),
    **dict.fromkeys(("bool_type", "bool_parsing"), "true or false"),
    **dict.fromkeys(("none_required",), "nothing"),
}
_SWITCHES: Final = {
    **dict.fromkeys(("on", "yes", "y", "1"), "true"),
    **dict.fromkeys(("off", "no", "n", "0"), "false"),
}


def kind_of(value: object) -> str:
    """Return a description of a value: `the number 12`, `a mapping`."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"the number {value}"
    if isinstance(value, str):
        return f"the text '{value if len(value) <= 40 else value[:39] + '…'}'"
    return "a mapping" if isinstance(value, Mapping) else "a list"


def wanted_kind(error: ErrorDetails) -> str | None:
    """Return the expected kind of value if the error is a wrong kind; otherwise None."""
    kind = _WANTED.get(error["type"])
    if kind is None and not isinstance(error["input"], str):
        if error["type"] in ("literal_error", "enum"):
            return "text"
        if error["type"] == "quantity" and isinstance(error["input"], Mapping | list):
            return "a quantity"
    return kind


def word(error: ErrorDetails, schema: Schema | None) -> Wording:
    """Return the message for an error.

    Args:
        error: The error from pydantic.
        schema: The model's schema of the value, if known.
    """
    wanted = _WANTED.get(error["type"])
    if wanted is not None:
        return _wrong_kind(wanted, error["input"], schema or {})
    speak = _SPEAKERS.get(error["type"])
    if speak is not None:
        return speak(error, schema)
    context = error.get("ctx", {})
    _, meant = misspelt_kind(error, schema) or ("", "")
    is_step = error["type"] == "step" and isinstance(error["input"], Mapping)
    return Wording(
        error["type"].replace("_", "-"),
        error["msg"],
        step_form(error["input"]) if is_step else str(context.get("expected", "")),
        str(context.get("suggestion", meant)),
    )


def _wrong_kind(wanted: str, value: object, schema: Mapping[str, Any]) -> Wording:
    message = f"expected {wanted}, got {kind_of(value)}"
    if wanted == "text" and isinstance(value, bool | int | float):
        shown = str(value).lower() if isinstance(value, bool) else value
        return Wording("kind", message, f"text; in quotes ('{shown}') it is text")
    if wanted == "true or false" and isinstance(value, str):
        switch = _SWITCHES.get(value.lower(), "")
        return Wording("kind", message, suggestion=switch, write=switch)
    if wanted == "a whole number" and isinstance(value, str):
        with suppress(ScalarError):
            number = resolve_plain(value.strip())
            if type(number) is int and number >= schema.get("ge", number):
                return Wording("kind", message, suggestion=value.strip(), write=value.strip())
    return Wording("kind", message)


def _choice(error: ErrorDetails, schema: Schema | None) -> Wording:
    value = error["input"]
    if schema is not None and schema["type"] == "literal":
        valid = [str(choice) for choice in schema["expected"]]
    elif schema is not None and schema["type"] == "enum":
        valid = [str(member.value) for member in schema["members"]]
    else:
        valid = re.findall(r"'([^']*)'", str(error.get("ctx", {}).get("expected", "")))
    if error["loc"][-1:] == ("format",) and _is_newer(value, valid):
        message = f"this program reads format {valid[-1]}, and this is format {value}"
        return Wording("choice", message, f"`format: {valid[-1]}`; a newer program may read this")
    suggestion = nearest(value, valid) if isinstance(value, str) else None
    message = f"expected {one_of(valid)}, got {kind_of(value)}"
    return Wording("choice", message, suggestion=suggestion or "")


def _is_newer(value: object, known: list[str]) -> bool:
    """Return whether a value is the number of a format that came after the known ones."""
    return type(value) is int and value > max(map(int, known))


def _tag(error: ErrorDetails, schema: Schema | None) -> Wording:
    context = error.get("ctx", {})
    value = error["input"]
    valid = list(_tags(schema)) or re.findall(r"'([^']*)'", str(context.get("expected_tags", "")))
    written = [str(context["tag"])] if "tag" in context else []
    if isinstance(value, Mapping) and not written:
        written = [key for key in value if isinstance(key, str)]
    elif isinstance(value, str):
        written = [value]
    near = (nearest(name, valid) for name in written)
    suggestion = next((name for name in near if name is not None), "")
    if isinstance(value, Mapping) and written:
        got = ", ".join(f"'{name}'" for name in written[:4])
    else:
        got = kind_of(value)
    return Wording("choice", f"expected {one_of(valid)}, got {got}", suggestion=suggestion)


def misspelt_kind(error: ErrorDetails, schema: Schema | None) -> tuple[str, str] | None:
    """Return the key instead of the one that says a mapping's kind, and what that should be."""
    if schema is None or schema.get("custom_error_type") != error["type"]:
        return None
    known, value = _tags(schema), error["input"]
    written = [key for key in value if isinstance(key, str)] if isinstance(value, Mapping) else []
    pairs = ((key, meant_key(key, known)) for key in written)
    return next(((key, close) for key, close in pairs if close), None)


def _tags(schema: Schema | None) -> list[str]:
    if schema is None or schema["type"] != "tagged-union":
        return []
    return [str(getattr(name, "value", name)) for name in schema["choices"]]


_BOUNDS: Final = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


def _bound(error: ErrorDetails, _: Schema | None) -> Wording:
    """Return the message for a value out of limits, with the limit in the value's unit."""
    key, relation = _BOUNDS[error["type"]]
    limit, value = error.get("ctx", {})[key], error["input"]
    shown = f"{limit}"
    if isinstance(value, str):
        with suppress(QuantityError):
            shown = in_unit_of(value, limit)
    return Wording("range", f"expected {relation} {shown}, got '{value}'")


def _length(error: ErrorDetails, _: Schema | None) -> Wording:
    context = error.get("ctx", {})
    what = "characters" if error["type"].startswith("string") else "entries"
    if "min_length" in context:
        if context["min_length"] == 1:
            return Wording("length", "this is empty", f"at least one of its {what}")
        return Wording("length", f"expected at least {context['min_length']} {what}")
    return Wording("length", f"expected at most {context.get('max_length')} {what}")


def _raised(error: ErrorDetails, _: Schema | None) -> Wording:
    """Return the message of a ValueError that a validator of the model raised."""
    cause = error.get("ctx", {}).get("error")
    if isinstance(cause, QuantityError):
        return Wording("quantity", cause.message, suggestion=cause.suggestion)
    return Wording("value", str(cause) if cause is not None else error["msg"])


def _quantity(error: ErrorDetails, _: Schema | None) -> Wording:
    context = error.get("ctx", {})
    return Wording("quantity", context["message"], context["expected"], context["suggestion"])


def _key(error: ErrorDetails, _: Schema | None) -> Wording:
    context = error.get("ctx", {})
    return Wording("value", context["message"], context["expected"])


_WRITTEN: Final = {
    Name: "a letter, then letters, digits and underscores",
    FaultCode: "a family and a detail in small letters, such as clamp.lost",
    Date: "a date such as 2026-01-31",
    Port: "an end, a junction, or a port of a tee such as t1.on or t1.branch",
    TypeName: "a package and a name, such as std_msgs/String",
}
_PATTERNS: Final = {
    part.pattern: text
    for kind, text in _WRITTEN.items()
    for part in get_args(kind)
    if isinstance(part, StringConstraints)
}
"""Descriptions of the texts that have patterns."""


def _pattern(error: ErrorDetails, _: Schema | None) -> Wording:
    pattern = error.get("ctx", {}).get("pattern")
    how = _PATTERNS.get(pattern, f"text like {pattern}")
    return Wording("pattern", f"{kind_of(error['input'])} does not fit", how)


def _infinite(error: ErrorDetails, _: Schema | None) -> Wording:
    return Wording("number", f"expected a finite number, got '{error['input']}'")


_SPEAKERS: Final[dict[str, Callable[[ErrorDetails, Schema | None], Wording]]] = {
    **dict.fromkeys(("literal_error", "enum"), _choice),
    **dict.fromkeys(("union_tag_invalid", "union_tag_not_found"), _tag),
    **dict.fromkeys(_BOUNDS, _bound),
    **dict.fromkeys(("too_short", "too_long", "string_too_short", "string_too_long"), _length),
    **dict.fromkeys(("value_error", "assertion_error"), _raised),
    "quantity": _quantity,
    "key": _key,
    "string_pattern_mismatch": _pattern,
    "finite_number": _infinite,
}


def merged(wanted: list[str], value: Any) -> Wording:
    """Return the message for a value that is of none of several kinds."""
    kinds = " or ".join(dict.fromkeys(wanted))
    return Wording("kind", f"expected {kinds}, got {kind_of(value)}")
