"""Specifications of the boards' frames and of the link's timing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, nan
from typing import Literal, NamedTuple

from pirate_sm.core._engine.sensing.plausibility_spec import WatchedSpec


class WheelSpec(NamedTuple):
    """A wheel for odometry: its place among the wheels, number indexes of angle and speed, slot.

    Attributes:
        load: Number index of its motor's current; -1 where none is measured.
        n_per_a: Force along its rim per current.
        stall_n: That of its motor at full duty while it stands.
        drag_n: What turns it while its motor does not.
        top_m_s: Speed of its rim at full duty without load.
    """

    place: int
    angle: int
    speed: int
    slot: int
    metres_per_rad: float
    load: int = -1
    n_per_a: float = 0.0
    stall_n: float = 0.0
    drag_n: float = 0.0
    top_m_s: float = inf

    def force_n(self, numbers: Sequence[float]) -> float:
        """Return the force along the rim, without its direction; NaN is unknown."""
        return abs(numbers[self.load]) * self.n_per_a if self.load >= 0 else nan

    def is_pushed(self, numbers: Sequence[float], setpoints: Sequence[float]) -> bool:
        """Return whether it turns faster than its motor would without load."""
        speed_m_s = abs(numbers[self.speed] * self.metres_per_rad)
        return speed_m_s > abs(setpoints[self.slot]) * self.top_m_s


class DerivedSpec(NamedTuple):
    """A number that is derived from others of its board, see :mod:`pirate_sm.core._engine.signals`.

    Attributes:
        target: Its index.
        sources: Theirs.
        factor: The torque per current; the length of a V's leg (eq. 3-2).
        more: What the wheels add to the height of a V.
        slot: That of the motor of a torque.
    """

    how: Literal["rate", "torque", "roll", "pitch", "norm", "diameter"]
    target: int
    sources: tuple[int, ...]
    factor: float = 1.0
    more: float = 0.0
    slot: int = -1


def board_name(id_: int) -> str:
    """Return the name by which missions mean a board."""
    return f"board_{id_}"


@dataclass(frozen=True)
class BoardSpec:
    """The content of one board's frame.

    Attributes:
        position: Index among the boards that report.
        channels: (place in the frame, number index, scale to SI).
        derived: The numbers that are derived from these alone.
        wheels: Its wheels.
        faults: Indexes of the fault rules that its signals can change.
        zeros: (number index, reading at the zero position) of each calibrated sensor.
        watched: Its sensors with plausibility limits.
    """

    id: int
    module: str
    position: int
    channels: tuple[tuple[int, int, float], ...]
    derived: tuple[DerivedSpec, ...]
    wheels: tuple[WheelSpec, ...]
    faults: tuple[int, ...]
    zeros: tuple[tuple[int, float], ...] = ()
    watched: WatchedSpec = field(default_factory=WatchedSpec)

    @property
    def name(self) -> str:
        """Return the name by which missions mean the board."""
        return board_name(self.id)

    @cached_property
    def length(self) -> int:
        """Return the smallest number of values in a valid frame."""
        return max((place + 1 for place, *_ in self.channels), default=0)

    @cached_property
    def number_set(self) -> frozenset[int]:
        """Return :attr:`numbers` as a set."""
        return frozenset(self.numbers)

    @property
    def vectors(self) -> tuple[tuple[int, ...], ...]:
        """Return the number indexes of each vector from which a number is derived."""
        return tuple(each.sources for each in self.derived if len(each.sources) == 3)

    @property
    def numbers(self) -> tuple[int, ...]:
        """Return the indexes of all numbers that depend on this board only."""
        measured = (target for _, target, _ in self.channels)
        return *measured, *(each.target for each in self.derived)


@dataclass(frozen=True)
class LinkSpec:
    """Timing of the link: report period, and limits for stale signals, silent boards and resends.

    Attributes:
        period_s: The time between two reports of one board. Reports at shorter intervals were
            delayed on their way.
    """

    period_s: float
    stale_after_s: float
    silent_after_s: float
    resend_after_s: float
    resend_limit: int

    @cached_property
    def listen_every_s(self) -> float:
        """Return the interval of the checks for silent boards and stale signals."""
        return min(self.stale_after_s, self.silent_after_s) / 2
