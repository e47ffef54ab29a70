"""Effects in words, the same in every view, log, report and table.

What a view adds of its own (arrows, places, whole sentences) stands with the view.
"""

from __future__ import annotations

import re
from typing import Any

from pirate_sm.model import effects as fx
from pirate_sm.model.events import Tick


def with_reason(text: str, reason: str) -> str:
    """Return the text with its reason behind a colon, where there is one."""
    return f"{text}: {reason}" if reason else text


def command_words(it: fx.CommandStatus) -> str:
    """Return what has become of a command, and why."""
    return with_reason(f"{it.name} {it.status}", it.reason)


def condition_words(it: fx.WaitArmed) -> str:
    """Return the conditions that a wait waits for."""
    return " or ".join(it.conditions)


def trigger_reason(it: fx.TriggerFired, *, nominal: bool) -> str:
    """Return why a trigger fired; in a trace its script, and nobody else, passes over waits."""
    return "taken by the trace" if nominal and it.reason == fx.TAKEN else it.reason


def fault_words(it: fx.Fault) -> str:
    """Return what is wrong, behind its code."""
    return f"{it.code}: {it.message}"


def handling_words(it: fx.Fault) -> str:
    """Return what follows from a fault."""
    return {"continue": "the mission goes on", "stop": "safe stop"}.get(
        it.handling, f"→ {it.handling}"
    )


def choice_words(it: fx.Ask) -> str:
    """Return the answers that a question offers."""
    return " / ".join(it.choices)


def question_words(it: fx.Ask) -> str:
    """Return a question with the answers that it offers."""
    return f"{it.question} ({choice_words(it)})"


def field_words(thing: Any) -> str:
    """Return what an event or effect is, and each field with its name and value, in one line.

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
    return with_reason(name, ", ".join(said))


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_value, value))})"
    return "none" if value is None else str(value)
