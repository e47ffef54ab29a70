"""The base class of all models: they are frozen, and unknown keys are errors.

The "Attributes" of a class's docstring are also the descriptions of its keys in editors, because
:mod:`pirate_sm.cli.model_schema` copies them into the JSON Schemas.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

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

LONGEST_NAME = 64

Name = Annotated[
    str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=LONGEST_NAME)
]
"""A name that an expression can use: a letter, then letters, digits and underscores."""

FaultCode = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*(\.[a-z0-9_]+)+$")]
"""The code of a fault, ``family.detail``."""

DEFINED = "x-defined"
"""Key of a JSON Schema that refers to a definition by a name known to the schema generator."""


def by_key(
    keys: Sequence[str], *, custom_error_type: str, custom_error_message: str
) -> Discriminator:
    """Return a discriminator that chooses the model by the first of these keys that a value has.

    Args:
        keys: The tags.
        custom_error_type: Type of the error for a value without any of the keys.
        custom_error_message: Message of that error.
    """

    def kind_of(value: Any) -> str | None:
        return next((key for key in keys if _has(value, key)), None)

    return Discriminator(
        kind_of, custom_error_type=custom_error_type, custom_error_message=custom_error_message
    )


def _has(value: Any, key: str) -> bool:
    return key in value if isinstance(value, dict) else hasattr(value, key)


@dataclass(frozen=True, slots=True)
class AlsoWritten:
    """JSON Schema annotation for other forms of the value, which a before-validator accepts.

    Attributes:
        forms: Returns the schemas of the other forms for the schema of the usual form.
    """

    forms: Callable[[JsonSchemaValue], list[JsonSchemaValue]]

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        usual = handler(schema)
        return {"anyOf": [*self.forms(usual), usual]}


@dataclass(frozen=True, slots=True)
class Defined:
    """JSON Schema annotation for a value whose kind is defined once, by name."""

    name: str

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {DEFINED: self.name}


def _no_truth(value: Any) -> Any:
    """Return the value; raise ValueError for a boolean, which Python would accept as 0 or 1."""
    if isinstance(value, bool):
        raise ValueError(f"expected a number, got '{str(value).lower()}'")
    return value


OR_ONE = (
    BeforeValidator(lambda value: [value] if isinstance(value, str) else value),
    AlsoWritten(lambda usual: [usual["items"]]),
)
"""Annotations of a list of texts in whose place a single one may be written."""

Format = Annotated[Literal[1], BeforeValidator(_no_truth)]
"""The version of a file's format."""

Date = Annotated[str, StringConstraints(pattern=r"^\d{4}-\d{2}-\d{2}$")]

Sign = Annotated[Literal[1, -1], BeforeValidator(_no_truth)]

Condition = Annotated[str, Defined("Condition")]
"""The text of a condition, see ``docs/expressions.md``."""


class Frozen(BaseModel):
    """The base class of the parts of a file: immutable, compared by value, without extra keys."""

    # The model of a file is built, with all its parts, when such a file is first read. To build
    # each part for itself as well would take a tenth of the time of a run.
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True, defer_build=True)

    def __copy__(self) -> Self:
        """Return a copy without cached properties: those of other fields are others."""
        copied = super().__copy__()
        for name in copied.__dict__.keys() - type(self).model_fields.keys():
            del copied.__dict__[name]
        return copied
