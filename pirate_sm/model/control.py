"""Controls: other ways to actuate a robot's states, which a mission chooses by name."""

from __future__ import annotations

from pirate_sm.model.actuation import Stages
from pirate_sm.model.base import Frozen, Name


class Control(Frozen):
    """An overlay of ``actuation``: how some states drive their motors under this control.

    Attributes:
        description: One line for people.
        extends: The control that this one changes; by default the profile's ``actuation``.
        actuation: For some regions and states, what the slots get instead: duty cycles, speeds and
            torques. A state keeps its slots, its number of stages and the wheels that it drives.
    """

    description: str = ""
    extends: Name | None = None
    actuation: dict[Name, dict[Name, Stages]] = {}
