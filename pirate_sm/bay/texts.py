"""The message texts that stand beside a robot's profile."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.model.profile import Profile
from pirate_sm.rosserial import messages


def message_texts(folder: Path, profile: Profile) -> dict[str, str]:
    """Return the texts of the messages of the robot's link, by their names on the wire.

    Args:
        folder: The robot's, which holds its profile.
        profile: The robot.

    Raises:
        UsageError: It has no link, or a text cannot be read.
    """
    serial = messages.serial_of(profile)
    return messages.message_texts(folder / serial.messages, serial)
