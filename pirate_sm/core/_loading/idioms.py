"""How something is written here that other languages write otherwise."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, Final

from pirate_sm.core._expressions.parser import ExpressionFault
from pirate_sm.core.spelling import nearest

_KEYS: Final = {
    **dict.fromkeys(("next", "goto", "then_go"), "go"),
    **dict.fromkeys(("actions", "steps", "then"), "do"),
    **dict.fromkeys(("print", "echo", "message"), "log"),
    **dict.fromkeys(("wait_until", "wait_for"), "wait"),
}
TRIGGER: Final = "after"
"""The key of a trigger for which its value alone may be written."""

_PAUSES: Final = {"sleep", "delay", "pause"}
_UNKNOWN_UNIT: Final = re.compile(r"unknown unit '(\w+)'")
_UNKNOWN_PARAMETER: Final = re.compile(r"there is no parameter '\$(\w+)'")


def meant_key(written: str, valid: Iterable[str]) -> str:
    """Return the valid key that is meant, or one that is spelt alike; empty if there is none."""
    known = list(valid)
    own = _KEYS.get(written, "")
    return own if own in known else nearest(written, known) or ""


def step_form(step: Mapping[str, Any]) -> str:
    """Return how a step of another language is written here; empty if that is not known."""
    key, value = next(iter(step.items()), ("", None))
    if "then" in step:
        return f"`choose: [{{if: {step.get('if', '…')}, do: …}}]`"
    if key in _PAUSES:
        return f"`wait: [{{after: {value}}}]`"
    if key == "goto":
        return f"`go: {value}` in the phase, next to its `do`"
    if not key[:1].isupper():
        return ""
    if isinstance(value, Mapping):
        return f"`{{command: {key}, {', '.join(f'{k}: {v}' for k, v in value.items())}}}`"
    return f"`{key}`, and how far in a wait: `when: change(odometry) >= {value}`"


def expression_form(fault: ExpressionFault) -> str:
    """Return what is to be written instead of a faulty part of a condition, as far as known."""
    from pirate_sm.core._model.quantities import INCHES  # noqa: PLC0415 - pydantic is slow to load

    if (unit := _UNKNOWN_UNIT.match(fault.message)) and unit[1].lower() in INCHES:
        return f"mm: 1 {unit[1]} is {25.4 * INCHES[unit[1].lower()]:g} mm"
    if (name := _UNKNOWN_PARAMETER.match(fault.message)) and not fault.suggestion:
        return f"a declared one: `parameters: {{{name[1]}: {{type: …, default: …}}}}`"
    return "`==`" if fault.message.startswith("'is' ") else ""
