"""What the models of files say of their keys: which hold conditions, and how each is written.

A snippet is a key with what it must have, and a hole for each value that the author fills in.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from functools import lru_cache
from itertools import count
from typing import Any, NamedTuple

from pydantic import BaseModel

from pirate_sm.core._loading.yaml.error_wording import SchemaWalk
from pirate_sm.core._loading.yaml.filled_in import FILLED, filled_in, stand_in
from pirate_sm.core._model.base import Defined, Frozen


@lru_cache(maxsize=1)
def condition_keys() -> frozenset[str]:
    """Return the keys whose values are conditions, in some kind of file."""
    found, waiting = set[str](), [Frozen]
    while waiting:
        waiting += (model := waiting.pop()).__subclasses__()
        for name, field in model.model_fields.items():
            if repr(Defined("Condition")) in f"{field.annotation}{field.metadata}":
                found.add(field.alias or name)
    return frozenset(found)


class Snippet(NamedTuple):
    """A key with its value, and the other keys that the mapping must have next to it.

    Attributes:
        key: The key with its value, as YAML with holes such as ``${1:time}``.
        rest: The other keys with their values.
    """

    key: str
    rest: str = ""

    def text(self, opening: str) -> str:
        """Return it for an entry that begins so; on a line of its own other keys have no room."""
        if opening == "[" or (opening == "-" and self.rest):
            return f"{{{', '.join(filter(None, self))}}}"
        return ", ".join(filter(None, self)) if opening == "{" else self.key


class WrittenKeys(NamedTuple):
    """How keys can be written at a place.

    Attributes:
        snippets: Of the keys that need one.
        shared: Further keys, which things of all kinds have, if keys are offered that choose one.
    """

    snippets: Mapping[str, Snippet]
    shared: Set[str]


def written_keys(model: type[BaseModel], offered: Set[str]) -> WrittenKeys:
    """Return how keys can be written at a place.

    Args:
        model: The model of the file.
        offered: All keys, and other words, that can be written there.
    """
    return WrittenKeys(_snippets(model, offered), _shared_keys(model, offered))


def _snippets(model: type[BaseModel], offered: Set[str]) -> Mapping[str, Snippet]:
    found: dict[str, Snippet] = {}
    for keys, among in _forms(model):
        if keys.keys() <= offered:
            for key in keys.keys() - found.keys():
                each = _of(keys[key], key)
                found[key] = each if among else each._replace(rest="")
    return {key: each for key, each in found.items() if each.key}


def _shared_keys(model: type[BaseModel], offered: Set[str]) -> set[str]:
    found: set[str] = set()
    for kinds, among in _forms(model):
        if among and kinds.keys() <= offered:
            found |= set.intersection(*({*_keys(each)} for each in kinds.values()))
    return found - offered


def _keys(model: type[BaseModel]) -> tuple[str, ...]:
    walk = SchemaWalk(model)
    return walk.fields(walk.follow(()).schema)


@lru_cache(maxsize=8)
def _forms(model: type[BaseModel]) -> list[tuple[Mapping[str, type[BaseModel]], bool]]:
    """Return the keys that stand together in such a file, each with its model, most keys first.

    For each set is said whether there is one key of these for each kind of a thing.
    """
    model.model_rebuild()  # its schema is made only then
    schema, walk = model.__pydantic_core_schema__, SchemaWalk(model)
    parts = {each["cls"] for each in _nested(schema) if each.get("type") == "model"}
    named = {each.__name__: each for each in parts}
    found = list[tuple[Mapping[str, type[BaseModel]], bool]]()
    for each in _nested(schema):
        if each.get("type") == "tagged-union":
            kinds = {str(tag): walk.kind(choice) for tag, choice in each["choices"].items()}
            found.append(({tag: named[kind["model_name"]] for tag, kind in kinds.items()}, True))
    found += ((dict.fromkeys(_keys(each), each), False) for each in parts)
    return sorted(found, key=lambda form: -len(form[0]))


def _nested(schema: Any) -> Iterator[Mapping[str, Any]]:
    """Yield all schemas in a schema."""
    waiting = [schema]
    while waiting:
        node = waiting.pop()
        if isinstance(node, dict):
            yield node
            waiting += node.values()
        elif isinstance(node, list | tuple):
            waiting += node


@lru_cache(maxsize=512)
def _of(model: type[BaseModel], key: str) -> Snippet:
    """Return the snippet of a key of a mapping; an empty one for a text, or names below it."""
    walk = SchemaWalk(model)
    schema = walk.child(walk.follow(()).schema or {}, key)
    if schema is None or walk.kind(schema)["type"] == "dict":
        return Snippet("")
    data = filled_in(model, {key: stand_in(walk, schema)}) or {}
    if key not in data:
        return Snippet("")  # what it may be is not found
    numbers = count(1)
    texts = {each: f"{each}: {_flow(data[each], each, numbers)}" for each in {key: 0, **data}}
    first, rest = texts.pop(key), ", ".join(texts.values())
    return Snippet(first if isinstance(data[key], dict | list) else "", rest)


def _flow(value: Any, name: str, numbers: Iterator[int]) -> str:
    """Return a value on one line, with a hole for each text and number in it."""
    match value:
        case dict():
            inner = (f"{key}: {_flow(each, key, numbers)}" for key, each in value.items())
            return f"{{{', '.join(inner)}}}"
        case list():
            return f"[{', '.join(_flow(each, name, numbers) for each in value)}]"
        case _:
            return f"${{{next(numbers)}:{name if value in FILLED[:-1] else value}}}"
