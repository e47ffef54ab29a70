"""What turns one JSON value into a later one, for a page that has the first.

Most of the report of a run only grows, so a change is mostly what comes at the end of some lists.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from typing import Any, TypeAlias

Change: TypeAlias = tuple[list[str | int], Any] | tuple[list[str | int], int, list[Any]]
"""A path and its new value; or the path of a list, how many of its items stay, and the new rest."""


def changes(before: Any, after: Any, path: tuple[str | int, ...] = ()) -> Iterator[Change]:
    """Yield what turns one value into the other, to be done in this order.

    The order of keys does not count, nor does the type of values that are equal in Python.

    Args:
        before: Plain data as in JSON.
        after: The same later.
        path: Where the two stand.
    """
    if before == after and type(before) is type(after):
        return
    if isinstance(before, dict) and isinstance(after, dict) and before.keys() == after.keys():
        for key, value in after.items():
            yield from changes(before[key], value, (*path, key))
    elif isinstance(before, list) and isinstance(after, list):
        yield from _of_lists(before, after, path)
    else:
        yield [*path], after


def _of_lists(before: list[Any], after: list[Any], path: tuple[str | int, ...]) -> Iterator[Change]:
    common = min(len(before), len(after))
    if not all(isinstance(each, dict | list) for each in (*before[:1], *after[:1])):
        common = _same(before, after, common)
    else:
        for place in range(common):
            yield from changes(before[place], after[place], (*path, place))
    if common < len(before) or common < len(after):
        yield [*path], common, after[common:]


def _same(before: list[Any], after: list[Any], most: int) -> int:
    """Return how many items at the beginning are the same."""
    if before[:most] == after[:most]:
        return most
    return bisect_left(range(most), True, key=lambda n: before[: n + 1] != after[: n + 1])
