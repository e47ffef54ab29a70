"""What a loop can hear with a fresh frame."""

from __future__ import annotations

from math import nan
from typing import NamedTuple


class Circumstances(NamedTuple):
    """The signals after a frame, and what else loops go by.

    Attributes:
        numbers: Signals in SI; NaN is unknown.
        pitch_rad: How steep the pipe climbs ahead of the robot; NaN is unknown.
        now_s: When it is.
    """

    numbers: tuple[float, ...]
    pitch_rad: float = nan
    now_s: float = nan
