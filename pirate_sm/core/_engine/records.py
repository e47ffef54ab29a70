"""Speed up ``_replace`` of named tuples that are replaced often."""

from __future__ import annotations

from typing import Any, TypeVar

T = TypeVar("T", bound=tuple[Any, ...])


def often_replaced(kind: type[T]) -> type[T]:
    """Return the named tuple with a ``_replace`` that takes half the time.

    The engine replaces a dozen records in each step.
    """
    index = {name: number for number, name in enumerate(kind._fields)}  # type: ignore[attr-defined]
    new = tuple.__new__

    def _replace(self: T, /, **changes: Any) -> T:
        values = [*self]
        for name in changes:  # noqa: PLC0206 - faster than by items
            values[index[name]] = changes[name]
        return new(kind, values)

    kind._replace = _replace  # type: ignore[attr-defined]
    return kind
