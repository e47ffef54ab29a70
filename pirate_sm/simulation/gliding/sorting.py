"""Medians in compiled code."""

from __future__ import annotations

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import compiled


@compiled
def median_of(values: Floats, count: int) -> float:
    """Return the median of the first values, which are sorted; 0 for none."""
    for i in range(1, count):
        value = values[i]
        k = i
        while k > 0 and values[k - 1] > value:
            values[k] = values[k - 1]
            k -= 1
        values[k] = value
    if count == 0:
        return 0.0
    middle = count // 2
    if count % 2 == 1:
        return float(values[middle])
    return float((values[middle - 1] + values[middle]) / 2)


@compiled
def median(rows: Floats, column: int, count: int, sorted_: Floats) -> float:
    """Return the median of a column of the first rows; `sorted_` is scratch."""
    for k in range(count):
        sorted_[k] = rows[k, column]
    return median_of(sorted_, count)
