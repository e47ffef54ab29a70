"""Keeps a limited number of values over time, evenly spaced, however long a run is."""

from __future__ import annotations

from typing import TypeVar

T = TypeVar("T")


def add_evenly(
    times_s: list[float], things: list[T], new: tuple[float, T], apart_s: float, most: int
) -> float:
    """Append the new value, remove values that are too close, and return the new spacing.

    Args:
        times_s: Times of the values, ascending.
        things: The values.
        new: Time and value to append.
        apart_s: The least spacing, except before the newest value.
        most: The largest number of values to keep.

    Returns:
        The least spacing from now on.
    """
    at_s, thing = new
    newest_only = len(times_s) > 1 and times_s[-1] < times_s[-2] + apart_s
    if times_s and (at_s <= times_s[-1] or newest_only):
        times_s.pop()
        things.pop()
    times_s.append(at_s)
    things.append(thing)
    if len(times_s) > most:
        apart_s = 2 * (times_s[-1] - times_s[0]) / len(times_s)
        del times_s[1:-1:2], things[1:-1:2]
    return apart_s
