"""Load a robot from its folder: read, check and resolve its profile and chart."""

from __future__ import annotations

from pirate_sm.core._loading.robot.loader import (
    LoadedRobot,
    Polarity,
    load_robot,
    read_robot,
    with_fitted,
)

__all__ = ["LoadedRobot", "Polarity", "load_robot", "read_robot", "with_fitted"]
