"""Declares options and arguments that take a text: its form, its completion, its help."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import typer
from typer.models import ArgumentInfo, OptionInfo

Completion: TypeAlias = Callable[..., Any] | None
"""Answers a shell that completes the value; None where there is nothing to choose from."""


def option(metavar: str, completion: Completion, help_text: str, *names: str) -> OptionInfo:
    """Return an option whose value is a text.

    Args:
        metavar: The form of its value, as help shows it.
        completion: Which values fit.
        help_text: What it means.
        names: How it is written; without any, the field's name after two dashes.
    """
    info: OptionInfo = typer.Option(
        *names, metavar=metavar, autocompletion=completion, help=help_text
    )
    return info


def argument(metavar: str, completion: Completion, help_text: str) -> ArgumentInfo:
    """Return an argument whose value is a text; the parameters are those of :func:`option`."""
    info: ArgumentInfo = typer.Argument(metavar=metavar, autocompletion=completion, help=help_text)
    return info
