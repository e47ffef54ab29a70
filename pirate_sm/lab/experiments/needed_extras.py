"""Says whether what an extra installs is there, and how to get it."""

from __future__ import annotations

from importlib.util import find_spec

_NEEDED = {"campaign": "distributed", "physics": "mujoco", "serial": "serial", "vision": "cv2"}
"""Modules by the extra that installs them."""


def is_missing(extra: str) -> str:
    """Return that the module of an extra is missing, and what to do; empty if it is there."""
    module = _NEEDED.get(extra)
    if module is None or find_spec(module) is not None:
        return ""
    return f"{module} is not installed: pip install 'pirate-sm[{extra}]'"
