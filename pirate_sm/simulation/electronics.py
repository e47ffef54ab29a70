"""The boards of a simulated robot: setpoints become duties, quantities become raw counts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pirate_sm.simulation import digitizing
from pirate_sm.simulation.actuators import ROLL, SlotRoute
from pirate_sm.simulation.arrays import Floats, Words
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.physics import Physics, QuantityLayout
from pirate_sm.simulation.sensors import Sensors

_SPONTANEOUS_DUTY = 0.3


class Electronics:
    """The boards between the wire and the motors and sensors of a chain.

    Args:
        chain: The moving parts.
        routes: The route of each slot's setpoint.
        sensors: The channels of the boards.
        physics: Moves the chain.
        seed: Seed of the noise.

    Attributes:
        boards: Boards that report, in the order of their reports.
        rows: Row in the channel table, by signal.
        channels: The channel table, see :mod:`pirate_sm.simulation.digitizing`.
        counts: Last raw count of every channel.
        rng: State of the generator of noise.
    """

    def __init__(
        self,
        chain: ChainBody,
        routes: tuple[SlotRoute, ...],
        sensors: Sensors,
        physics: Physics,
        seed: int,
    ) -> None:
        self.chain, self.physics = chain, physics
        self.boards, self.rows = sensors.boards, sensors.rows
        self.counts: Floats = np.zeros(len(sensors.channels))
        self._routes = routes
        self.channels = sensors.channels.copy()
        self._quantities = physics.quantities
        self._layout = QuantityLayout(chain.nodes)
        self.rng: Words = np.array([seed], dtype=np.uint64)
        self.read(0, len(self.counts))

    @property
    def slots(self) -> int:
        """How many setpoints an array has."""
        return len(self._routes)

    def read(self, first: int, last: int) -> None:
        """Read the channels from `first` to before `last`."""
        digitizing.digitize(self.channels, first, last, self._quantities, self.counts, self.rng)

    def refusal(self, values: Sequence[float]) -> str:
        """Return why the setpoints are rejected; empty if they are accepted."""
        if len(values) != len(self._routes):
            return f"{len(values)} values for {len(self._routes)} slots"
        for index, (route, value) in enumerate(zip(self._routes, values, strict=True)):
            slack = 0.5 * route.step
            if not route.low - slack <= value <= route.high + slack:
                return f"slot {index}: {value} is outside {route.low:g}..{route.high:g}"
        return ""

    def set_values(self, values: Iterable[float]) -> None:
        """Put setpoints in force.

        Args:
            values: One per slot: duty cycles -1..1 and angles in rad, as the profile says.
        """
        for route, value in zip(self._routes, values, strict=True):
            if route.motor >= 0:
                self.physics.duties[route.motor] = value if route.moves(value) else 0.0
            elif route.motor == ROLL:
                self.physics.turn_roll_to(value)

    def cut(self, values: Iterable[float]) -> list[float]:
        """Return the setpoints, each clipped to the limits of its slot."""
        pairs = zip(self._routes, values, strict=True)
        return [min(max(value, route.low), route.high) for route, value in pairs]

    def rest(self) -> None:
        """Give duty 0 to every motor without a controller of its own."""
        self.physics.duties[:] = 0.0

    def twitch(self, rng: np.random.Generator) -> None:
        """Give one motor a random duty without a command."""
        driven = sorted({route.motor for route in self._routes if route.motor >= 0})
        duty = rng.uniform(-_SPONTANEOUS_DUTY, _SPONTANEOUS_DUTY)
        self.physics.duties[driven[int(rng.integers(len(driven)))]] = duty

    def restart(self) -> None:
        """Restart the boards: zero duties, the roll joint as it is, encoders from zero."""
        self.rest()
        self.physics.turn_roll_to(self.physics.rolls()[0])
        for row in self._showing(("wheel", "roll"), range(self.chain.nodes)):
            source = int(self.channels[row, digitizing.SOURCE])
            counts = self._quantities[source] * self.channels[row, digitizing.GAIN]
            self.channels[row, digitizing.OFFSET] = -counts

    def mute_wheel(self, wheel: int) -> None:
        """Make the angle of a wheel stand still, and its other channels show zero."""
        rows = self._showing(("wheel", "turned", "drive"), (wheel,))
        self.channels[rows, digitizing.GAIN : digitizing.SIGMA + 1] = 0.0
        for row in self._showing(("wheel",), (wheel,)):
            self.channels[row, digitizing.OFFSET] = self.counts[row]

    def shift(self, signal: str, counts: float) -> None:
        """Add this many counts to the offset of the signal's channel."""
        self.channels[self.rows[signal], digitizing.OFFSET] += counts

    def _showing(self, quantities: Sequence[str], wheels: Iterable[int]) -> list[int]:
        """Return the rows of channels that measure one of the quantities of one of the wheels."""
        sources = {self._layout.at(name, wheel) for wheel in wheels for name in quantities}
        column = self.channels[:, digitizing.SOURCE].tolist()
        return [row for row, source in enumerate(column) if int(source) in sources]
