"""Lets loaded missions be pickled, so that other processes can be sent them."""

from __future__ import annotations

from copyreg import pickle
from functools import cache, cached_property
from pickle import HIGHEST_PROTOCOL, Pickler
from types import MappingProxyType
from typing import Any


class MissionPickler(Pickler):
    """Writes what objects are made of, without the cached properties they have worked out.

    Another thread, which runs the mission, may be adding to those at any moment.
    """

    def reducer_override(self, each: Any) -> Any:
        """Return how to write an object with cached properties; any other as usual."""
        cached = _cached(each.__class__)
        if not cached:
            return NotImplemented
        make, arguments, state = each.__reduce_ex__(HIGHEST_PROTOCOL)[:3]
        # A copy is made at once: no other thread of Python runs meanwhile.
        kept = {name: it for name, it in (state or {}).copy().items() if name not in cached}
        return make, arguments, kept


@cache
def _cached(kind: type) -> frozenset[str]:
    """Return the names of the cached properties of a class."""
    found = (vars(each).items() for each in kind.__mro__)
    return frozenset(name for of in found for name, it in of if isinstance(it, cached_property))


def _read_only(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(values)


def _reduced(view: MappingProxyType[Any, Any]) -> tuple[Any, ...]:
    return _read_only, (dict(view),)


def make_picklable() -> None:
    """Teach :mod:`pickle` the read-only views that a loaded mission holds; it knows none itself."""
    pickle(MappingProxyType, _reduced)
