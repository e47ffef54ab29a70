"""Note where the wheels are after each cycle, in compiled code."""

from __future__ import annotations

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import compiled


@compiled
def note_places(centres: Floats, rolls: Floats, cycles: float, trail: Floats) -> None:
    """Note where the robot is.

    Args:
        centres: Coordinates of the wheels' centres, one wheel after the other, m.
        rolls: Angle of the roll joint, then the roll of each part, rad.
        cycles: How many cycles have passed, in all.
        trail: A row for each of the last cycles: the centres, then the rolls. Changed.
    """
    row = trail[int(cycles) % trail.shape[0]]
    for k in range(centres.shape[0]):
        row[k] = centres[k]
    for k in range(rolls.shape[0]):
        row[centres.shape[0] + k] = rolls[k]
