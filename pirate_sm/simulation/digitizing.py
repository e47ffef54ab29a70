"""The compiled part of the sensors: converts quantities to raw counts, with seeded noise."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Words
from pirate_sm.simulation.machine_code import compiled

# Columns of `channels`: count = gain * quantity + offset + noise; `absolute` takes its magnitude.
SOURCE, GAIN, OFFSET, SIGMA, ABSOLUTE = range(5)
CHANNEL_COLUMNS = 5


@compiled
def _gauss(rng: Words) -> float:
    """Draw one approximately normal number (splitmix64, sum of four uniforms)."""
    rng[0] += np.uint64(0x9E3779B97F4A7C15)
    z = rng[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    mask = np.uint64(0xFFFF)
    total = float(z & mask) + float((z >> np.uint64(16)) & mask)
    total += float((z >> np.uint64(32)) & mask) + float(z >> np.uint64(48))
    return (total - 131070.0) / 37837.0


@compiled
def digitize(
    channels: Floats, first: int, last: int, quantities: Floats, counts: Floats, rng: Words
) -> None:
    """Write fresh counts of the channels from `first` to before `last` into `counts`.

    Args:
        channels: `(channels, CHANNEL_COLUMNS)`.
        first: First channel to read.
        last: Channel after the last one to read.
        quantities: Quantities in the layout of `physics.QuantityLayout`, SI.
        counts: `(channels,)`; changed.
        rng: `(1,)`, the generator's state; changed.
    """
    for c in range(first, last):
        value = quantities[int(channels[c, SOURCE])] * channels[c, GAIN] + channels[c, OFFSET]
        if channels[c, SIGMA] > 0.0:
            value += channels[c, SIGMA] * _gauss(rng)
        if channels[c, ABSOLUTE] != 0.0:
            value = abs(value)
        counts[c] = np.rint(value)
