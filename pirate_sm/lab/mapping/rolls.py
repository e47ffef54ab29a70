"""How the robot's plane is rolled in the legs of a map, and how steep these are, by gravity."""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan, pi, radians, remainder

from pirate_sm.core.sensing import BodySpec
from pirate_sm.lab.mapping.legs import Map, middle
from pirate_sm.lab.mapping.looks import RobotLook
from pirate_sm.lab.mapping.spots import Spot

_STEEP_RAD = radians(60)
"""In a steeper leg a robot's roll is not taken from gravity [decided]."""

_FELT = 9
"""This number of the last rolls counts."""

_FELT_EVERY_S = 0.2


class Rolls:
    """Feels gravity.

    Args:
        made: The map, whose legs take note of it.
        body: The robot's chain.
    """

    def __init__(self, made: Map, body: BodySpec) -> None:
        self._map, self._body = made, body
        self._rho_rad = 0.0
        self._felt_s = -1.0

    def feel(self, look: RobotLook, spots: Mapping[int, Spot]) -> None:
        """Take note of gravity in the leg of the part that feels it."""
        around, spot, made = look.around, spots.get(look.part), self._map
        if spot is None or look.at_s < self._felt_s + _FELT_EVERY_S or isnan(around.pitch_rad):
            return
        self._felt_s = look.at_s
        leg = made.legs[spot.leg]
        leg.pitches_rad.append(around.pitch_rad)
        roll_rad = around.roll_rad - self._twist(look, look.part)
        if not isnan(roll_rad) and abs(around.pitch_rad) < _STEEP_RAD:
            leg.rolls_rad.append(roll_rad)
        if spot.leg == made.start[0] and not made.bends:
            made.pitch_rad = middle(leg.pitches_rad)
            if len(leg.rolls_rad) <= _FELT:
                made.roll_rad = middle(leg.rolls_rad)

    def of_part(self, look: RobotLook, part: int, leg: int) -> float:
        """Return the roll of a part's plane in a leg against the frame carried along, rad."""
        felt_rad, frame_rad = self._map.legs[leg].rolls_rad[-_FELT:], self._map.roll_of(leg)
        if felt_rad and not isnan(frame_rad):
            self._rho_rad = remainder(middle(felt_rad) - frame_rad, 2 * pi)
        return self._rho_rad + self._twist(look, part)

    def _twist(self, look: RobotLook, part: int) -> float:
        """Return the roll of a part's plane against that of the rear half, rad."""
        roll, ahead = (
            self._body.roll,
            part >= 0 and (self._body.parts[part].wheels[0] <= self._body.roll_link),
        )
        return look.numbers[roll] if roll >= 0 and ahead else 0.0
