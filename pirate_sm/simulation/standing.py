"""The pose of a simulated robot at the end of a recording; this module does not need NumPy."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.core.geometry import Vector


class Standing(NamedTuple):
    """The pose of a simulated robot at the end of an interrupted recording.

    Attributes:
        places_m: Centre of each wheel.
        bends_rad: Angle of each driven joint of the body; ``torques_nm``: the torque of its spring.
        values: The setpoints that hold the robot.
        at_s: Time since the run began.
        rolls_rad: The angle of the roll joint, and the rolls of the parts ahead and behind against
            the pipe where they are.
    """

    places_m: tuple[Vector, ...]
    bends_rad: tuple[float, ...]
    torques_nm: tuple[float, ...]
    values: tuple[float, ...]
    at_s: float
    rolls_rad: tuple[float, ...]
