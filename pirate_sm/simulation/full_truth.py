"""The true state of a simulated robot."""

from __future__ import annotations

from dataclasses import dataclass

from pirate_sm.core.simulation import Truth


@dataclass(frozen=True, kw_only=True)
class FullTruth(Truth):
    """The true state: positions for views, and quantities that only a simulation knows.

    Attributes:
        arcs_m: Position of each wheel along the pipe.
        bends_rad: Angle at each wheel between its two links.
        torques_nm: Torque in the bend joint at each wheel; 0 without a joint.
        gone: Whether the robot has left the pipe for good.
    """

    arcs_m: tuple[float, ...]
    bends_rad: tuple[float, ...]
    torques_nm: tuple[float, ...]
    gone: bool
