"""What the frames of a robot's boards contain, and how often they come."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple

from pirate_sm.engine.sensing.plausibility_spec import WatchedSpec


class WheelSpec(NamedTuple):
    """A wheel for odometry: its place among the wheels, number indexes of angle and speed, slot."""

    place: int
    angle: int
    speed: int
    slot: int
    metres_per_rad: float


class Vector(NamedTuple):
    """A number made of three others: their indexes and the one it goes to."""

    how: Literal["roll", "pitch", "norm"]
    sources: tuple[int, ...]
    target: int


@dataclass(frozen=True)
class BoardSpec:
    """What one board's frame tells.

    Attributes:
        position: Index among the boards that are listened to.
        channels: (place in the frame, number index, scale to SI).
        rates: (number index, index of its rate).
        torques: (number index of the current, slot, scale, number index of the torque).
        vectors: Accelerometer numbers.
        diameters: (number index of the apex angle, link length, 2r, target) of eq. 3-2.
        wheels: Its wheels.
        faults: Indexes of the fault rules that its signals can change.
        zeros: (number index, what its sensor shows when it is zero), where that was calibrated.
        watched: Its sensors whose values have limits.
    """

    id: int
    module: str
    position: int
    channels: tuple[tuple[int, int, float], ...]
    rates: tuple[tuple[int, int], ...]
    torques: tuple[tuple[int, int, float, int], ...]
    vectors: tuple[Vector, ...]
    diameters: tuple[tuple[int, float, float, int], ...]
    wheels: tuple[WheelSpec, ...]
    faults: tuple[int, ...]
    zeros: tuple[tuple[int, float], ...] = ()
    watched: WatchedSpec = field(default_factory=WatchedSpec)

    @cached_property
    def length(self) -> int:
        """Return how many values a frame must have at least."""
        return max((place + 1 for place, *_ in self.channels), default=0)

    @cached_property
    def number_set(self) -> frozenset[int]:
        """Return :attr:`numbers`, to be asked whether one is among them."""
        return frozenset(self.numbers)

    @property
    def numbers(self) -> tuple[int, ...]:
        """Return the indexes of every number that comes from this board alone."""
        return (
            *(target for _, target, _ in self.channels),
            *(target for _, target in self.rates),
            *(target for *_, target in self.torques),
            *(vector.target for vector in self.vectors),
            *(target for *_, target in self.diameters),
        )


@dataclass(frozen=True)
class LinkSpec:
    """When a signal is stale, a board silent, an array sent again; how often a board reports.

    Attributes:
        period_s: The time between two reports of one board. What comes at shorter intervals has
            waited somewhere.
    """

    period_s: float
    stale_after_s: float
    silent_after_s: float
    resend_after_s: float
    resend_limit: int

    @cached_property
    def listen_every_s(self) -> float:
        """Return how often to look which boards are silent and which signals stale."""
        return min(self.stale_after_s, self.silent_after_s) / 2
