"""The base of all models: they are frozen, and an unknown key is an error.

What a class's docstring lists under "Attributes" is also what editors show for the key: the JSON
Schemas take it from there (:mod:`pirate_sm.schemas`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    GetJsonSchemaHandler,
    StringConstraints,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]
"""A name that an expression can use: a letter, then letters, digits and underscores."""

FaultCode = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*(\.[a-z0-9_]+)+$")]
"""A fault's code, ``family.detail``."""

DEFINED = "x-defined"
"""Key of a JSON Schema that stands for a definition which the schemas' writer knows by name."""


def by_key(
    keys: Sequence[str], *, custom_error_type: str, custom_error_message: str
) -> Discriminator:
    """Return a discriminator: the first of these keys that a value has is the tag of its model.

    Args:
        keys: The tags.
        custom_error_type: The error's type where a value has none of them.
        custom_error_message: Its message.
    """

    def kind_of(value: Any) -> str | None:
        return next((key for key in keys if _has(value, key)), None)

    return Discriminator(
        kind_of,
        custom_error_type=custom_error_type,
        custom_error_message=custom_error_message,
    )


def _has(value: Any, key: str) -> bool:
    return key in value if isinstance(value, dict) else hasattr(value, key)


@dataclass(frozen=True, slots=True)
class AlsoWritten:
    """Says in JSON Schema that a validator before takes other forms of the value as well.

    Attributes:
        forms: Gives the schemas of the other forms, from the schema of the usual one.
    """

    forms: Callable[[JsonSchemaValue], list[JsonSchemaValue]]

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        usual = handler(schema)
        return {"anyOf": [*self.forms(usual), usual]}


@dataclass(frozen=True, slots=True)
class Defined:
    """Says in JSON Schema that the value is of a kind that is defined once, by name."""

    name: str

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {DEFINED: self.name}


def _no_truth(value: Any) -> Any:
    """Return the value unless it is a boolean: for Python `true` would be the 1 in it."""
    if isinstance(value, bool):
        raise ValueError(f"expected a number, got '{str(value).lower()}'")
    return value


Format = Annotated[Literal[1], BeforeValidator(_no_truth)]
"""The version of a file's format."""

Sign = Annotated[Literal[1, -1], BeforeValidator(_no_truth)]

Condition = Annotated[str, Defined("Condition")]
"""The text of a condition, see ``docs/expressions.md``."""


class Frozen(BaseModel):
    """A piece of a file: immutable, compared by value, strict about its keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)
