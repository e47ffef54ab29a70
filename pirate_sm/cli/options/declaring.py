"""Declares options and arguments by their form, their completion and their help."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import typer

Completion: TypeAlias = Callable[..., Any] | None
"""Answers a shell that completes the value; None where there is nothing to choose from."""


def option(metavar: str, completion: Completion, help_text: str, *names: str) -> Any:
    """Return an option whose value is a text.

    Args:
        metavar: The form of its value, as help shows it.
        completion: Which values fit.
        help_text: What it means.
        names: How it is written; without any, the field's name after two dashes.
    """
    return typer.Option(*names, metavar=metavar, autocompletion=completion, help=help_text)


def argument(metavar: str, completion: Completion, help_text: str) -> Any:
    """Return an argument whose value is a text; the parameters are those of :func:`option`."""
    return typer.Argument(metavar=metavar, autocompletion=completion, help=help_text)


def flag(help_text: str, *names: str) -> Any:
    """Return an option without a value; the parameters are those of :func:`option`."""
    return typer.Option(*names, help=help_text)
