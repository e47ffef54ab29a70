"""Missions in YAML for in-pipe inspection robots: checked, simulated and run by one engine.

These functions are the public API (``docs/python.md``): :func:`load`, :func:`check`,
:func:`run`, :func:`session`, :func:`advance_all`, :func:`batch`, :func:`sweep` and :func:`read`.
Importing the package imports nothing else, to keep the command line fast. Each name is imported
when it is first used.
"""

from __future__ import annotations

TYPE_CHECKING = False  # importing typing would take half of the time of a help text

if TYPE_CHECKING:
    from pirate_sm.api import (
        BackendError,
        CheckError,
        Columns,
        ExpressionError,
        Finding,
        LoadedMission,
        LoadError,
        Page,
        PirateError,
        RecordingError,
        Run,
        Session,
        UsageError,
        advance_all,
        batch,
        check,
        load,
        read,
        run,
        session,
        sweep,
    )

__version__ = "0.1.0"

__all__ = [
    "BackendError",
    "CheckError",
    "Columns",
    "ExpressionError",
    "Finding",
    "LoadError",
    "LoadedMission",
    "Page",
    "PirateError",
    "RecordingError",
    "Run",
    "Session",
    "UsageError",
    "advance_all",
    "batch",
    "check",
    "load",
    "read",
    "run",
    "session",
    "sweep",
]


def __getattr__(name: str) -> object:
    """Import a name of the API when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module 'pirate_sm' has no attribute '{name}'")
    from importlib import import_module

    value = globals()[name] = getattr(import_module("pirate_sm.api"), name)
    return value


def __dir__() -> list[str]:
    """Return all names including the API, for completion in a notebook."""
    return sorted({*globals(), *__all__})
