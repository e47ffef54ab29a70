"""Environments of Gymnasium in which an agent commands the robot; importing this registers them."""

from __future__ import annotations

from pirate_sm.lab.learning import (
    IN_PIPE,
    REWARDS,
    Outcome,
    Reward,
    Transition,
    least_commands,
    least_slip,
    progress,
    reach,
)

__all__ = [
    "IN_PIPE",
    "REWARDS",
    "Outcome",
    "Reward",
    "Transition",
    "least_commands",
    "least_slip",
    "progress",
    "reach",
]
