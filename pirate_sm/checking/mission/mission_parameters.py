"""Rules about parameters: each is used and set, and the mission is possible at its limits."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from math import inf, nan

from pydantic import BaseModel

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.mission.mission_view import MissionView, within_reach
from pirate_sm.core.documents import Document, Problems
from pirate_sm.core.expressions import ExpressionError, compile_condition
from pirate_sm.core.fields import Parameter
from pirate_sm.core.loading import LoadedMission, Value, Values, defaults, read_value
from pirate_sm.core.models import (
    AskStep,
    ConditionTrigger,
    End,
    LogStep,
    Mission,
    OperatorTrigger,
    Phase,
    TimeTrigger,
    WaitStep,
)
from pirate_sm.core.units import QuantityError

_USE = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")
_FIELD = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")
_PROSE = {"description", "log", "ask", "succeed", "fail"}
"""Texts in which `$name` has no meaning."""


def unused_parameters(view: MissionView) -> Iterator[Finding]:
    """Yield parameters that no condition, time, count, text or argument uses."""
    yield from unused_in(view.loaded.mission, view.loaded.documents[0])


def unused_in(mission: Mission, document: Document) -> Iterator[Finding]:
    """Yield unused parameters of a mission that need not be loaded."""
    used = set(_used(mission)) if mission.parameters else set()
    for name in mission.parameters:
        if name not in used:
            place = document.place_of(("parameters", name), key=True)
            message = f"nothing in this mission uses the parameter '{name}'"
            yield at(document, place, "parameter.unused", message)


def check_settings(
    mission: Mission, document: Document, settings: Collection[str]
) -> tuple[Finding, ...]:
    """Return findings for parameters without a default or a setting.

    This applies only if no other mission calls this one.
    """
    found = []
    for name, definition in mission.parameters.items():
        if definition.default is None and name not in settings:
            place = document.place_of(("parameters", name), key=True)
            message = f"nothing sets the parameter '{name}'"
            fix = "give it a default, or set it for each run of the mission"
            found.append(
                at(
                    document,
                    place,
                    "mission.parameter",
                    message,
                    severity=Severity.WARNING,
                    fix=fix,
                )
            )
    return tuple(found)


def parameter_limits(view: MissionView) -> Iterator[Finding]:
    """Yield limits of parameters at which a trigger or a condition can never be true."""
    loaded, mission, document = view.loaded, view.loaded.mission, view.loaded.documents[0]
    if not mission.parameters:
        return
    conditions = within_reach(view)
    problems = Problems(document)
    values = defaults(mission.parameters, problems)
    texts = [text for text in _conditions(mission) if "$" in text]
    waits = tuple(_waits(mission))
    for name, definition in mission.parameters.items():
        for key in ("min", "max"):
            limit = getattr(definition, key)
            with suppress(QuantityError):
                if limit is None:
                    continue
                at_limit = {**values, name: Value(read_value(definition, limit), str(limit))}
                text = next((t for t in texts if _never(t, name, at_limit, loaded, conditions)), "")
                late = set(_late(waits, at_limit)) - set(_late(waits, values))
                if text and not _never(text, name, values, loaded, conditions):
                    what = f"'{text}' can never be true"
                elif late:
                    what = f"{min(late)} comes only after its wait is over"
                else:
                    continue
                message = f"with {name} at its {key} of {limit}, {what}"
                place = document.place_of(("parameters", name, key))
                yield at(document, place, "parameter.limit", message)


def _late(waits: Iterable[Phase | WaitStep], values: Values) -> Iterator[str]:
    """Yield triggers that with these values come only after the end of their wait."""
    for wait in waits:
        within_s = inf if wait.within is None else _seconds(wait.within.time, values)
        ends_s = [_seconds(t.after, values) for t in wait.wait if isinstance(t, TimeTrigger)]
        for trigger in wait.wait:
            match trigger:
                case ConditionTrigger(when=when, held=held):
                    if _seconds(held, values) > min([within_s, *ends_s]):
                        yield f"'{when}', to be held for {_written(held)},"
                case TimeTrigger(after=after):
                    if _seconds(after, values) > within_s:
                        yield f"'after {_written(after)}'"
                case OperatorTrigger():
                    pass


def _waits(value: object) -> Iterator[Phase | WaitStep]:
    """Yield the phases and steps of a mission that wait."""
    if isinstance(value, Phase | WaitStep):
        yield value
    for _, inner in _inside(value):
        yield from _waits(inner)


def _written(value: float | Parameter) -> str:
    return f"${value.name}" if isinstance(value, Parameter) else f"{value:g} s"


def _seconds(value: float | Parameter, values: Values) -> float:
    """Return the time in s; NaN if the parameter has no value."""
    if not isinstance(value, Parameter):
        return value
    return values[value.name].quantity.value if value.name in values else nan


def _never(
    text: str, name: str, values: Values, loaded: LoadedMission, conditions: Conditions
) -> bool:
    """Return whether the condition is impossible with these values; False if some are missing."""
    if name not in _USE.findall(text) or not set(_USE.findall(text)) <= values.keys():
        return False
    constants = {each: value.quantity for each, value in values.items()}
    try:
        condition = compile_condition(text, loaded.robot.vocabulary.with_changes, constants)
    except ExpressionError:
        return False  # reported already
    return not conditions.anywhere([(condition.tree, True)], loaded.robot.table.configurations)


def _conditions(value: object) -> Iterator[str]:
    """Yield the conditions in a part of a mission."""
    for name, inner in _inside(value):
        if name in {"when", "condition"} and isinstance(inner, str):
            yield inner
        else:
            yield from _conditions(inner)


def _used(value: object) -> Iterator[str]:
    """Yield the names of parameters in a part of a mission."""
    if isinstance(value, Parameter):
        yield value.name
    elif isinstance(value, str):
        yield from _USE.findall(value)
    elif isinstance(value, BaseModel):
        yield from _shown(value)
    for name, inner in _inside(value):
        if name not in _PROSE and not (isinstance(value, Mission) and name == "parameters"):
            yield from _used(inner)


def _inside(value: object) -> Iterator[tuple[str, object]]:
    """Yield all nested values of a part of a mission, each with its field name."""
    if isinstance(value, Mapping):
        yield from (("", each) for each in value.values())
    elif isinstance(value, tuple | list):
        yield from (("", each) for each in value)
    elif isinstance(value, BaseModel):
        yield from ((name, getattr(value, name)) for name in type(value).model_fields)


def _shown(value: BaseModel) -> Iterator[str]:
    """Yield the names in the texts for the operator."""
    match value:
        case LogStep(log=text) | AskStep(ask=text):
            yield from _FIELD.findall(text)
        case End(succeed=succeed, fail=fail):
            yield from _FIELD.findall(f"{succeed} {fail}")
        case _:
            pass
