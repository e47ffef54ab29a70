"""How a simulated robot stood when a recording was cut off; an order of a run needs no NumPy."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.core.geometry import Vector


class Standing(NamedTuple):
    """How a simulated robot stood when a recording was cut off.

    Attributes:
        places_m: Centre of each wheel.
        bends_rad: Angle of each driven joint of the body; ``torques_nm`` what its spring bears.
        values: The setpoints that hold it.
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
