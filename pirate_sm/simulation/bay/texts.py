"""The message definitions beside a robot's profile."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.core.profile import Profile
from pirate_sm.robot.rosserial import messages


def message_texts(folder: Path, profile: Profile) -> dict[str, str]:
    """Return the ``.msg`` texts of the robot's link, by message name (``package/Type``).

    Args:
        folder: The robot's folder, with its profile.
        profile: The robot's profile.

    Raises:
        UsageError: The robot has no link, or a text cannot be read.
    """
    serial = messages.serial_of(profile)
    return messages.message_texts(folder / serial.messages, serial)
