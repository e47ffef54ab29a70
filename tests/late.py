"""Modules that take long to import: not in every process that only collects their tests."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class _Late:
    """Stands for a module, which is imported when something of it is first used."""

    def __init__(self, name: str) -> None:
        self._module_name = name

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # whoever collects tests asks everything for these
            raise AttributeError(name)
        return getattr(import_module(self._module_name), name)


def late(name: str) -> Any:
    """Return the module of this name, which is not imported yet."""
    return _Late(name)
