"""Registers the environments with Gymnasium, which imports them when they are made."""

from __future__ import annotations

from pirate_sm.errors import not_installed

IN_PIPE = "pirate_sm/InPipe-v0"


def register() -> None:
    """Register the environments.

    Raises:
        UsageError: Gymnasium is not installed.
    """
    try:
        import gymnasium  # noqa: PLC0415  # the extra may be missing
    except ImportError as error:
        raise not_installed("learning", "gymnasium", "gym") from error
    gymnasium.register(
        IN_PIPE,
        entry_point="pirate_sm.learning.environment:InPipe",
        vector_entry_point="pirate_sm.learning.vector:InPipes",
    )
