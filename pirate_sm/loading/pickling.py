"""Lets loaded missions be pickled, so that other processes can be sent them."""

from __future__ import annotations

from copyreg import pickle
from types import MappingProxyType
from typing import Any


def _read_only(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(values)


def _reduced(view: MappingProxyType[Any, Any]) -> tuple[Any, ...]:
    return _read_only, (dict(view),)


def make_picklable() -> None:
    """Teach :mod:`pickle` the read-only views that a loaded mission holds; it knows none itself."""
    pickle(MappingProxyType, _reduced)
