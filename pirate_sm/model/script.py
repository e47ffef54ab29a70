"""What a trace shall fire, entry by entry."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pirate_sm.model.base import Frozen, Name
from pirate_sm.model.quantities import Duration


class ScriptEntry(Frozen):
    """In a wait (of ``phase``, if given) that has the trigger, take it after the time ``after``."""

    trigger: Name
    after: Annotated[Duration, Field(ge=0)] | None = None
    phase: str = ""
