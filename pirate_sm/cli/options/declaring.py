"""Declares the options and arguments of commands as fields of a dataclass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, field
from typing import Any, TypeAlias

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
