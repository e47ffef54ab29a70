"""Declares the options and arguments of commands as fields of a dataclass."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, field, fields
from inspect import Parameter, signature
from math import inf
from typing import Annotated, Any, TypeAlias

import typer

Completion: TypeAlias = Callable[..., Any] | None
"""Answers a shell that completes the value; None where there is nothing to choose from."""


def declared(parameter: Any, default: Any) -> Any:
    """Return a field of an options class with what declares it to the command line's library."""
    return field(default=default, metadata={"parameter": parameter})


def option(
    metavar: str, completion: Completion, help_text: str, *names: str, default: Any = None
) -> Any:
    """Return an option whose value is a text.

    Args:
        metavar: The form of its value, as help shows it.
        completion: Which values fit.
        help_text: What it means.
        names: How it is written; without any, the field's name after two dashes.
        default: Its value where it is not given.
    """
    shape = typer.Option(*names, metavar=metavar, autocompletion=completion, help=help_text)
    return declared(shape, default)


def argument(
    metavar: str | None, completion: Completion, help_text: str, *, default: Any = MISSING
) -> Any:
    """Return an argument; the parameters are those of :func:`option`.

    Without a default it must be given; without a metavar help shows the field's name.
    """
    shape = typer.Argument(metavar=metavar, autocompletion=completion, help=help_text)
    return declared(shape, default)


def flag(help_text: str, *names: str, default: bool = False) -> Any:
    """Return an option without a value; the parameters are those of :func:`option`."""
    return declared(typer.Option(*names, help=help_text), default)


def typed(help_text: str, *names: str, default: Any = None, **more: Any) -> Any:
    """Return an option whose type says its form: a number, or one of several words.

    Args:
        help_text: What it means.
        names: How it is written; without any, the field's name after two dashes.
        default: Its value where it is not given.
        more: Bounds of a number, ``min`` and ``max``, and a ``metavar``.
    """
    return declared(typer.Option(*names, help=help_text, **more), default)


def parameters_of(options: type) -> list[Parameter]:
    """Return the parameters of a command with these options, in the order of its help text."""
    found: list[tuple[float, Parameter]] = []
    taken = signature(options, eval_str=True).parameters
    for each in fields(options):
        parameter, place = each.metadata.get("parameter"), each.metadata.get("place", inf)
        if parameter is not None:
            own = taken[each.name]
            own = own.replace(annotation=Annotated[own.annotation, parameter])
            found.append((place, own))
        found += each.metadata.get("several", ())
    return [each for _, each in sorted(found, key=lambda placed: placed[0])]


def made(options: type[Any], given: Mapping[str, Any]) -> Any:
    """Return the options with these values; a field for several options takes what is left."""
    own = {each.name: given[each.name] for each in fields(options) if each.name in given}
    rest = {name: value for name, value in given.items() if name not in own}
    several = (each.name for each in fields(options) if "several" in each.metadata)
    return options(**own, **dict.fromkeys(several, rest))
