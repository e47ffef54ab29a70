"""The channels of a robot's boards: the quantity that each measures, and its scale in counts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.expressions import Vocabulary, compile_expression
from pirate_sm.core.profile import Channel, Profile, Slot
from pirate_sm.core.profile import derived as kinds
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.digitizing import CHANNEL_COLUMNS
from pirate_sm.simulation.mechanics import ChainBody, needed
from pirate_sm.simulation.physics import QuantityLayout


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
