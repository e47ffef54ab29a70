"""Environments of Gymnasium in which an agent commands the robot; importing this registers them.

``docs/learning.md`` says what they are. They need the extra ``gym``.
"""

from __future__ import annotations

from pirate_sm.core.errors import not_installed
from pirate_sm.lab.learning.rewards import (
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

IN_PIPE = "pirate_sm/InPipe-v0"

try:
    import gymnasium
except ImportError as error:
    raise not_installed("learning", "gymnasium", "gym") from error

gymnasium.register(
    IN_PIPE,
    entry_point="pirate_sm.lab.learning.environment:InPipe",
    vector_entry_point="pirate_sm.lab.learning.vector:InPipes",
)
