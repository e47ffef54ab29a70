"""The memory of a board's sensors for judging their next reading, and that reading."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan, nan
from typing import NamedTuple

from pirate_sm.core._engine.records import often_replaced

Numbers = Sequence[float]


class SensorMemory(NamedTuple):
    """The memory of one sensor; it does not change while its readings are normal.

    Attributes:
        calm: Whether the last reading was believed and none of ``good`` to ``jumped`` but
            ``since_s`` is in use.
        good: The last believed value; ``good_s``: its time; ``seen``: the readings until then.
        wound: The torque of the joint's spring at ``good_s``; NaN if it is unknown.
        held: The last readings since then that were not believed; the first and the last one of a
            joint that has jumped.
        since_s: When its values began to be believed again, after a jump or as a counter that has
            restarted. While it is not believed after a jump: since when its readings have followed
            one another, if that can restore belief; else infinite.
        running: Direction of a trend faster than the motor; 0 without one.
        outside: Whether it was reported as outside its range; ``jumped``: as having jumped.
        stuck: The value at which it is stuck; NaN if it is not.
        hidden: Number of spikes so far; ``spikes``: the times of the last ones.
        spiking_s: When it was last reported as spiking.
    """

    calm: bool = True
    good: float = nan
    good_s: float = -inf
    wound: float = nan
    seen: int = 0
    held: tuple[float, ...] = ()
    since_s: float = -inf
    running: float = 0.0
    outside: bool = False
    jumped: bool = False
    stuck: float = nan
    hidden: int = 0
    spikes: tuple[float, ...] = ()
    spiking_s: float = -inf

    @property
    def doubted(self) -> bool:
        """Return whether the last reading is not believed."""
        return bool(self.held) or self.jumped or not isnan(self.stuck)


@often_replaced
class BoardMemory(NamedTuple):
    """The memory of the sensors of one board.

    Attributes:
        seen: Number of readings, counted up to a limit.
        special: Whether a sensor is not calm.
        doubted: Number indexes that depend on a sensor whose last reading is not believed.
    """

    channels: tuple[SensorMemory, ...]
    seen: int = 0
    special: bool = False
    doubted: frozenset[int] = frozenset()


class Reading(NamedTuple):
    """The circumstances of one frame of a board.

    Attributes:
        before: Numbers after the board's previous frame.
        elapsed_s: Time since that frame.
        now_s: Time of this frame.
    """

    before: Numbers
    elapsed_s: float
    now_s: float
