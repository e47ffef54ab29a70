"""Says whether the backend of a further run of an experiment can be used here."""

from __future__ import annotations

from importlib.util import find_spec

_NEEDED = {"physics": "mujoco"}
"""Modules of backends that the extra of the experiments does not install."""


def is_missing(backend: str) -> str:
    """Return why a backend cannot be used here, and what to do; empty where it can."""
    module = _NEEDED.get(backend)
    if module is None or find_spec(module) is not None:
        return ""
    return f"{module} is not installed: pip install 'pirate-sm[{backend}]'"
