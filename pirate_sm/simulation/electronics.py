"""The boards of a simulated robot: setpoints become duties, quantities become raw counts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.expressions import Vocabulary, compile_expression
from pirate_sm.core.models import Channel, Profile, Slot
from pirate_sm.core.models import signals as kinds
from pirate_sm.simulation import digitizing
from pirate_sm.simulation.arrays import Floats, Words
from pirate_sm.simulation.digitizing import CHANNEL_COLUMNS
from pirate_sm.simulation.physics import ChainBody, Physics, QuantityLayout, needed

# --- routes of setpoints -------------------------------------------------------------------------


NOWHERE, ROLL = -2, -1


class SlotRoute(NamedTuple):
    """The motor that a setpoint drives, and its limits.

    Attributes:
        motor: Index in the physics' duties, ``ROLL`` for the roll joint, ``NOWHERE`` if nothing
            moves.
        low: Smallest accepted value, duty or rad.
        high: Largest accepted value.
        step: Resolution of the wire.
        least: Duty cycle below which the motor stands still.
    """

    motor: int
    low: float
    high: float
    step: float
    least: float = 0.0

    def moves(self, duty: float) -> bool:
        """Whether a duty cycle moves the motor."""
        return abs(duty) > self.least - 0.5 * self.step


def routes_of(profile: Profile, chain: ChainBody) -> tuple[SlotRoute, ...]:
    """Return the route of each slot, in the order of the wire."""
    return tuple(_route(profile, slot, chain) for slot in profile.slots)


def _route(profile: Profile, slot: Slot, chain: ChainBody) -> SlotRoute:
    link = profile.link
    if slot.unit == "angle":
        limit = slot.limit if slot.limit is not None else 7.0
        to = ROLL if slot.roll is not None else NOWHERE
        return SlotRoute(to, -limit, limit, link.angle_resolution)
    to, least = NOWHERE, 0.0
    if slot.wheel is not None:
        to = chain.nodes + chain.wheel_index[slot.wheel]
    elif slot.joint is not None:
        to, least = chain.joint_index[slot.joint], profile.motors[slot.motor].least_duty
    return SlotRoute(to, -1.0, 1.0, link.duty_resolution, least)


# --- channels ------------------------------------------------------------------------------------


class BoardChannels(NamedTuple):
    """A board that reports, and its rows in the channel table."""

    board: int
    first: int
    last: int


@dataclass(frozen=True)
class Sensors:
    """The channel table of a robot.

    Attributes:
        boards: Boards that report, in the order of their reports.
        channels: `(channels, digitizing.CHANNEL_COLUMNS)`, one board after the other.
        rows: Row in the channel table, by signal.
    """

    boards: tuple[BoardChannels, ...]
    channels: Floats
    rows: dict[str, int]


def sensors_of(profile: Profile, chain: ChainBody) -> Sensors:
    """Return the channels of all fitted boards.

    Raises:
        UsageError: The profile lacks a number that only a simulator needs.
    """
    table: list[tuple[float, ...]] = []
    rows: dict[str, int] = {}
    boards: list[BoardChannels] = []
    for board in profile.boards:
        if not (board.fitted and board.channels_fitted and board.channels):
            continue
        first = len(table)
        for channel in board.channels:
            if channel.signal is not None:
                rows[channel.signal] = len(table)
            table.append(_channel(profile, channel, chain))
        boards.append(BoardChannels(board.id, first, len(table)))
    channels = np.array(table, dtype=np.float64).reshape(len(table), CHANNEL_COLUMNS)
    return Sensors(tuple(boards), channels, rows)


@lru_cache(maxsize=1024)
def scale_of(text: str) -> float:
    """Return the SI value of a constant expression such as ``360 deg / 4096``."""
    value = compile_expression(text, Vocabulary({})).evaluate((), ())
    if not isinstance(value, float):
        raise UsageError(f"'{text}' is not a number")
    return value


def _channel(profile: Profile, channel: Channel, chain: ChainBody) -> tuple[float, ...]:
    """Return a row of the channel table: the inverse of the conversion from raw to SI."""
    layout = QuantityLayout(chain.nodes)
    noise = profile.simulation.noise
    per_count = scale_of(profile.conversions[channel.convert].scale) if channel.convert else 1.0
    slot = next((slot for slot in profile.slots if slot.name == channel.slot), None)
    senses = channel.senses
    if senses is None:
        return (0.0, 0.0, 0.0, 0.0, 0.0)
    if slot is None:
        sigma = noise.acceleration if senses.startswith("acc") else 0.0
        return (layout.at(senses), 1.0 / per_count, 0.0, sigma / per_count, 0.0)
    if slot.wheel is not None:
        at = chain.wheel_index[slot.wheel]
    else:
        at = chain.joint_index.get(slot.joint or "", 0)
    if senses == "current":
        source, gain = _current(profile, channel, slot, layout, at)
        return (source, gain / per_count, 0.0, noise.current / per_count, 1.0)
    if slot.wheel is not None:
        return (layout.at("wheel" if senses == "angle" else senses, at), 1.0 / per_count, 0, 0, 0)
    if slot.joint is None:
        return (layout.at("roll"), 1.0 / per_count, 0, 0, 0)
    sigma = noise.angle
    quantity = "bend"
    if senses == "torque":
        # The spring is read as a difference of two angles.
        quantity = "bend_torque"
        sigma *= chain.joints[at].stiffness_nm_rad
    return (layout.at(quantity, at), 1.0 / per_count, 0.0, sigma / per_count, 0.0)


def _current(
    profile: Profile, channel: Channel, slot: Slot, layout: QuantityLayout, at: int
) -> tuple[int, float]:
    """Return the quantity that a motor's current follows, and amperes per unit of it."""
    motor = profile.motors[slot.motor]
    stall_a = needed(motor.stall_current, slot.motor, "stall_current")
    if slot.joint is not None:
        return layout.at("bend_current", at), stall_a
    if slot.wheel is None:
        return layout.at("roll_current"), stall_a
    for derived in profile.derived.values():
        if isinstance(derived, kinds.TorqueOf) and derived.torque_of == channel.signal:
            # The reported current must read back the torque applied (thesis eq. 5-3).
            return layout.at("drive", at), 1.0 / scale_of(derived.scale)
    stall_nm = needed(motor.stall_torque, slot.motor, "stall_torque")
    return layout.at("drive", at), stall_a / stall_nm


# --- boards --------------------------------------------------------------------------------------


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
