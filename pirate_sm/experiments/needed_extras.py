"""Says whether what a further run of an experiment needs is installed here."""

from __future__ import annotations

from importlib.util import find_spec

_NEEDED = {"physics": "mujoco", "serial": "serial", "vision": "cv2"}
"""Modules by the extra that installs them, where the extra of the experiments does not."""


def is_missing(extra: str) -> str:
    """Return why a further run cannot be made here, and what to do; empty if it can."""
    module = _NEEDED.get(extra)
    if module is None or find_spec(module) is not None:
        return ""
    return f"{module} is not installed: pip install 'pirate-sm[{extra}]'"
