"""The robot's posture in the pipe by its signals, in compiled code.

The same operations in the same order give the same bits as
:meth:`pirate_sm.core.sensing.BodySpec.heading_in_pipe`.
"""

from __future__ import annotations

from math import asin, atan2, cos, sin, sqrt

import numpy as np

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.machine_code import compiled


@compiled
def _angle(wheel: int, numbers: Floats, chain: Floats) -> float:
    joint = int(chain[wheel, col.H_JOINT])
    return float(numbers[joint]) if joint >= 0 else 0.0


@compiled
def _heading(link: int, first: int, numbers: Floats, chain: Floats) -> float:
    """Return the heading of a link relative to the one behind wheel ``first``."""
    heading = 0.0
    for passed in range(first + 1, link + 1):
        heading = heading + _angle(passed, numbers, chain)
    for passed in range(first - 1, link - 1, -1):
        heading = heading - _angle(passed + 1, numbers, chain)
    return heading


@compiled
def _lean(first: int, last: int, aside_m: float, numbers: Floats, chain: Floats) -> float:
    """Return the rotation of the chain that aligns a part with the pipe, rad."""
    x, y = 0.0, 0.0
    for link in range(first, last):  # the first wheel stands at the origin
        heading = _heading(link, first, numbers, chain)
        x -= chain[link, col.H_LENGTH] * cos(heading)
        y -= chain[link, col.H_LENGTH] * sin(heading)
    along, across = 0.0 - x, 0.0 - y
    length = sqrt(along * along + across * across)
    if length == 0.0:
        length = 1.0
    rise = (chain[first, col.H_SIDE] - chain[last, col.H_SIDE]) * aside_m / length
    if np.isnan(rise):
        return np.nan
    return asin(max(-1.0, min(1.0, rise))) - atan2(across, along)


@compiled
def heading_in_pipe(
    part: int, link: int, numbers: Floats, chain: Floats, parts: Floats, body: Floats
) -> float:
    """Return a link's heading relative to the pipe axis at a clamped part, rad; NaN is unknown."""
    first, last = int(parts[part, col.Q_FIRST]), int(parts[part, col.Q_LAST])
    aside_m = 0.0
    if chain[first, col.H_SIDE] != chain[last, col.H_SIDE]:
        diameter = int(parts[part, col.Q_DIAMETER])
        span_m = numbers[diameter] if diameter >= 0 else np.nan
        aside_m = span_m / 2 - body[col.I_RADIUS_M]
    turn = _lean(first, last, aside_m, numbers, chain)
    return _heading(link, min(first, chain.shape[0] - 2), numbers, chain) + turn
