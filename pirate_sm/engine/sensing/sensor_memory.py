"""What is remembered of the sensors of a board to judge their next reading, and that reading."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan, nan
from typing import NamedTuple

Numbers = Sequence[float]


class SensorMemory(NamedTuple):
    """What is remembered of one sensor; unchanged as long as nothing is special about it.

    Attributes:
        calm: Whether the last reading was believed and none of the next six fields is in use.
        good: The last believed value, ``good_s`` when it came, ``seen`` how many had come by then.
        wound: The torque of the joint's spring then; NaN where it is not known.
        held: Readings since that were not believed, the last few of them.
        running: Direction of a trend that is faster than the motor; 0 without one.
        outside: Whether it has been reported as outside its range; ``jumped`` as having jumped.
        stuck: The value at which it is stuck; NaN where it is not.
        hidden: How many spikes have been hidden, ``spikes`` when the last of them were.
        spiking_s: When it was last reported as spiking.
        same: What it has shown since ``same_s`` while its motor is driven without load.
        rest: Where it came to rest after the setpoints changed at ``rest_of_s``.
        proven: Whether a second reading has confirmed ``rest``.
        away: How many readings in a row were far from ``rest``.
        unasked: Whether that motion has been reported.
    """

    calm: bool = True
    good: float = nan
    good_s: float = -inf
    wound: float = nan
    seen: int = 0
    held: tuple[float, ...] = ()
    running: float = 0.0
    outside: bool = False
    jumped: bool = False
    stuck: float = nan
    hidden: int = 0
    spikes: tuple[float, ...] = ()
    spiking_s: float = -inf
    same: float = nan
    same_s: float = inf
    rest: float = nan
    rest_of_s: float = inf
    proven: bool = False
    away: int = 0
    unasked: bool = False

    @property
    def doubted(self) -> bool:
        """Whether the last reading is not believed."""
        return bool(self.held) or self.jumped or not isnan(self.stuck)


class BoardMemory(NamedTuple):
    """What is remembered of the sensors of one board.

    Attributes:
        seen: How many readings have come, as far as that matters.
        special: Whether a channel is not calm.
        doubted: Number indexes that rest on a sensor whose last reading is not believed.
    """

    channels: tuple[SensorMemory, ...]
    seen: int = 0
    special: bool = False
    doubted: frozenset[int] = frozenset()


class Reading(NamedTuple):
    """The circumstances of one frame of a board.

    Attributes:
        before: Numbers as they were shown after the board's previous frame.
        elapsed_s: Since that frame.
        now_s: When this one came.
        setpoints: The array that was last sent; empty before the first.
        since_s: When it was sent.
        settled: Whether nothing can move any more: no wheel is driven, and the array is old.
    """

    before: Numbers
    elapsed_s: float
    now_s: float
    setpoints: Numbers = ()
    since_s: float = inf
    settled: bool = False
