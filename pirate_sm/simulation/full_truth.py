"""What only a simulation knows of a robot."""

from __future__ import annotations

from dataclasses import dataclass

from pirate_sm.model.true_position import Truth


@dataclass(frozen=True, kw_only=True)
class FullTruth(Truth):
    """What only a simulation knows, beside what a view shows.

    Attributes:
        arcs_m: Place of each wheel along the pipe.
        bends_rad: Angle at each wheel between the links that meet there.
        torques_nm: What the bend joint at each wheel bears; 0 where there is none.
        gone: Whether the robot has left the pipe for good.
    """

    arcs_m: tuple[float, ...]
    bends_rad: tuple[float, ...]
    torques_nm: tuple[float, ...]
    gone: bool
