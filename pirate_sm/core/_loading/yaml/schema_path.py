"""Find the path in the file of a pydantic error's location.

Such a location also contains labels of unions (`steps.0.CallStep.with`), which look like keys. The
schema that pydantic compiled for the model is followed in parallel to distinguish them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from pydantic import BaseModel

from pirate_sm.core._loading.problems import Path

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
        found = self._child(schema, 0)
        return self._plain(found) if found else None

    def parent(self, location: Location) -> Schema | None:
        """Return the schema of the mapping that contains a location's last key."""
        return self.follow(location[:-1]).schema

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
                child = self._child(schema, part)
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

    def _child(self, schema: Schema, part: str | int) -> Schema | None:
        """Return the schema of the value at a key or index."""
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
