"""Read the descriptions of a model and its keys from docstrings."""

from __future__ import annotations

import inspect
import re

from pydantic import BaseModel

_ATTRIBUTE = re.compile(r"    (\w+): (.*)")


def summary(model: type[BaseModel]) -> str:
    """Return the docstring's description of the model, as Markdown."""
    return _markdown(_parts(model)[0])


def explanations(model: type[BaseModel]) -> dict[str, str]:
    """Return the docstring's description of each field, including inherited ones, as Markdown."""
    found: dict[str, str] = {}
    for each in reversed(model.__mro__):
        if issubclass(each, BaseModel):
            found |= _attributes(_parts(each)[1])
    return {name: _markdown(text) for name, text in found.items()}


def _parts(model: type[BaseModel]) -> tuple[str, str]:
    text = inspect.cleandoc(model.__dict__.get("__doc__") or "")
    head, _, attributes = text.partition("Attributes:\n")
    return head.strip(), attributes


def _attributes(section: str) -> dict[str, str]:
    found: dict[str, str] = {}
    name = ""
    for line in section.splitlines():
        match = _ATTRIBUTE.match(line)
        if match is not None:
            name = match[1]
            found[name] = match[2]
        elif name:
            found[name] += f" {line.strip()}"
    return found


def _markdown(text: str) -> str:
    paragraphs = [" ".join(part.split()) for part in text.split("\n\n")]
    return "\n\n".join(paragraphs).replace("``", "`").strip()
