"""Parameters that a mission declares and nothing in it uses, or nothing sets."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping

from pydantic import BaseModel

from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.loading.source import Document
from pirate_sm.model.mission import AskStep, End, LogStep, Mission
from pirate_sm.model.quantities import Parameter

_USE = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")
_FIELD = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")
_PROSE = {"description", "log", "ask", "succeed", "fail"}
"""Texts in which `$name` means nothing."""


def check_parameters(mission: Mission, document: Document) -> tuple[Finding, ...]:
    """A warning for each parameter that is used in no condition, time, count, text or argument."""
    used = set(_used(mission))
    found = []
    for name in mission.parameters:
        if name not in used:
            place = document.place_of(("parameters", name), key=True)
            message = f"nothing in this mission uses the parameter '{name}'"
            found.append(at(document, place, "parameter.unused", Severity.WARNING, message))
    return tuple(found)


def check_settings(
    mission: Mission, document: Document, settings: Collection[str]
) -> tuple[Finding, ...]:
    """A warning for each parameter without a default that the settings leave without a value.

    It is of use only where no other mission calls this one.
    """
    found = []
    for name, definition in mission.parameters.items():
        if definition.default is None and name not in settings:
            place = document.place_of(("parameters", name), key=True)
            message = f"nothing sets the parameter '{name}'"
            mend = f"give it a default, or run the mission with --set {name}=…"
            found.append(
                at(document, place, "mission.parameter", Severity.WARNING, message, mend=mend)
            )
    return tuple(found)


def _used(value: object) -> Iterator[str]:
    """The names of parameters in a part of a mission."""
    if isinstance(value, Parameter):
        yield value.name
    elif isinstance(value, str):
        yield from _USE.findall(value)
    elif isinstance(value, Mapping):
        for each in value.values():
            yield from _used(each)
    elif isinstance(value, tuple | list):
        for each in value:
            yield from _used(each)
    elif isinstance(value, BaseModel):
        yield from _shown(value)
        for name in type(value).model_fields:
            if name not in _PROSE and not (isinstance(value, Mission) and name == "parameters"):
                yield from _used(getattr(value, name))


def _shown(value: BaseModel) -> Iterator[str]:
    """The names in the texts that a person reads."""
    match value:
        case LogStep(log=text) | AskStep(ask=text):
            yield from _FIELD.findall(text)
        case End(succeed=succeed, fail=fail):
            yield from _FIELD.findall(f"{succeed} {fail}")
