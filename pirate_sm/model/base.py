"""What all models share: they are frozen, and a key that they do not know is an error."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, StringConstraints

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]
"""A name that an expression can use: a letter, then letters, digits and underscores."""

FaultCode = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*(\.[a-z0-9_]+)+$")]
"""A fault's code, ``family.detail``."""


class Frozen(BaseModel):
    """A piece of a file: immutable, compared by value, strict about its keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)
