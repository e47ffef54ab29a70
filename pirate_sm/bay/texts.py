"""The message texts that stand beside a robot's profile."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.bay.wire import serial_of
from pirate_sm.errors import UsageError
from pirate_sm.model.profile import Profile


def message_texts(folder: Path, profile: Profile) -> dict[str, str]:
    """The text of each message type of the robot's link, by its name on the wire.

    Args:
        folder: The robot's, which holds its profile.
        profile: The robot.

    Raises:
        UsageError: It has no link, or a text cannot be read.
    """
    serial = serial_of(profile)
    texts: dict[str, str] = {}
    for topic in (serial.setpoints, serial.echo, serial.state):
        file = folder / serial.messages / f"{topic.type.partition('/')[2]}.msg"
        try:
            texts[topic.type] = file.read_text("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise UsageError(f"the text of {topic.type} cannot be read: {error}") from None
    return texts
