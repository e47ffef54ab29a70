"""Load a robot from its folder: profile and chart are read, checked and resolved."""

from __future__ import annotations

from pirate_sm.loading.robot.loader import LoadedRobot, Polarity, load_robot

__all__ = ["LoadedRobot", "Polarity", "load_robot"]
