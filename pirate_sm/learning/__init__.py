"""Environments of Gymnasium in which an agent commands the robot; importing this registers them.

``docs/learning.md`` says what they are. They need the extra ``gym``.
"""

from __future__ import annotations

from pirate_sm.learning.registration import IN_PIPE, register
from pirate_sm.learning.rewards import REWARDS, Reward, least_commands, least_slip, progress, reach
from pirate_sm.learning.transition import Outcome, Transition

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

register()
