"""Events and effects in words, with numbers as a person reads them."""

from __future__ import annotations

import re
from typing import Any

from pirate_sm.model.events import Tick


def worded(thing: Any) -> str:
    """An event or effect: what it is, and each field with its name and value; in one line.

    Args:
        thing: The event or effect; None for the start of the engine.
    """
    if thing is None:
        return "the start"
    if isinstance(thing, Tick):
        return "the passing of time"
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(thing).__name__).lower()
    fields = zip(thing._fields, thing, strict=True)
    said = [f"{field.replace('_', ' ')} {_value(value)}" for field, value in fields if value != ""]
    return f"{name}: {', '.join(said)}" if said else name


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_value, value))})"
    return "none" if value is None else str(value)
