"""Finds the files, options and parameters in which two runs differ."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from pirate_sm.running.recording.format.header import RunHeader

_NAMED_ALREADY = {"mission", "robot", "pipe", "backend", "fidelity", "detector", "settings"}
"""Options for which the header has the resulting value as well."""


class Unlike(NamedTuple):
    """A difference in the set-up of two runs.

    Attributes:
        name: Its name, such as ``seed`` or ``parameter give_up``.
        first: Its value in the first run, as text; ``second`` in the second.
    """

    name: str
    first: str
    second: str


def unlike(first: RunHeader, second: RunHeader) -> tuple[Unlike, ...]:
    """Return all differences in the set-up of two runs, except the times of their start."""
    one, other = dict(_circumstances(first)), dict(_circumstances(second))
    names = dict.fromkeys((*one, *other))
    return tuple(
        Unlike(name, _as_text(one.get(name)), _as_text(other.get(name)))
        for name in names
        if one.get(name) != other.get(name)
    )


def _circumstances(it: RunHeader) -> Iterator[tuple[str, Any]]:
    """Yield name and value of every item in the set-up of a run."""
    for name in ("mission", "robot", "polarity", "pipe", "backend", "fidelity", "detector"):
        yield name, getattr(it, name)
    for name, value in it.options.items():
        if name not in _NAMED_ALREADY:
            yield name.replace("_", " "), value
    for name, text in it.parameters.items():
        yield f"parameter {name}", text
    for name, zero_rad in it.zeros.items():
        yield f"zero of {name}", f"{zero_rad:.6g} rad"
    for file in it.files:
        name = file.role if file.role != "called" else f"called {Path(file.name).stem}"
        yield f"text of the {name}", f"{Path(file.name).name}, SHA-256 {file.sha256[:8]}…"
    yield "version", it.version


def _as_text(value: Any) -> str:
    """Return the value as text."""
    if value in (None, [], {}, ""):
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list) and all(isinstance(each, str) for each in value):
        return ", ".join(value)
    return f"{len(value)} given" if isinstance(value, list | dict) else str(value)
