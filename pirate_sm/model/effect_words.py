"""The wording of effects, common to all views, logs, reports and tables.

Each view adds its own arrows, places or sentences.
"""

from __future__ import annotations

import re
from typing import Any

from pirate_sm.model import effects as fx
from pirate_sm.model.events import Tick


def with_reason(text: str, reason: str) -> str:
    """Return the text, followed by a colon and the reason if there is one."""
    return f"{text}: {reason}" if reason else text


def command_words(it: fx.CommandStatus) -> str:
    """Return the status of a command with its reason."""
    return with_reason(f"{it.name} {it.status}", it.reason)


def condition_words(it: fx.WaitArmed) -> str:
    """Return the conditions of a wait."""
    return " or ".join(it.conditions)


def trigger_reason(it: fx.TriggerFired, *, nominal: bool) -> str:
    """Return why a trigger fired; in a trace only the script can skip a wait."""
    return "taken by the trace" if nominal and it.reason == fx.TAKEN else it.reason


def fault_words(it: fx.Fault) -> str:
    """Return the code and the message of a fault."""
    return f"{it.code}: {it.message}"


def handling_words(it: fx.Fault) -> str:
    """Return the handling of a fault."""
    return {"continue": "the mission goes on", "stop": "safe stop"}.get(
        it.handling, f"→ {it.handling}"
    )


def choice_words(it: fx.Ask) -> str:
    """Return the choices of a question."""
    return " / ".join(it.choices)


def question_words(it: fx.Ask) -> str:
    """Return a question with its choices."""
    return f"{it.question} ({choice_words(it)})"


def field_words(thing: Any) -> str:
    """Return an event or effect as one line, with the names and values of its fields.

    Args:
        thing: The event or effect; None for the start of the engine.
    """
    if thing is None:
        return "the start"
    if isinstance(thing, Tick):
        return "the passing of time"
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(thing).__name__).lower()
    fields = zip(thing._fields, thing, strict=True)
    said = [
        f"{field.replace('_', ' ')} {_value(value)}"
        for field, value in fields
        if value != "" and (field, value) != ("unmet", ())
    ]
    return with_reason(name, ", ".join(said))


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_value, value))})"
    return "none" if value is None else str(value)
