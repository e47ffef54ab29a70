"""The topics that a robot's profile names, and the results of asking a device for them."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from pirate_sm.robot.rosserial.frames import LONGEST_PAYLOAD
from pirate_sm.robot.rosserial.topics import Direction, TopicInfo


class Wanted(NamedTuple):
    """A topic that the robot's profile names.

    Attributes:
        direction: What the device does with it.
        text: Our definition, for people.
        longest: Bytes of its longest payload.
        answers: The device only sends it to answer a writing. So it does not show that the device
            works of its own accord, and does not end a silence.
    """

    name: str
    type: str
    md5: str
    direction: Direction
    text: str = ""
    longest: int = LONGEST_PAYLOAD
    answers: bool = False


class TopicPayload(NamedTuple):
    """A payload on the wanted topic with index ``which``."""

    which: int
    payload: bytes


class TopicsKnown(NamedTuple):
    """Event: all wanted topics are known.

    Attributes:
        again: They had been known before; the device had to be asked anew.
        silence_s: How long the device had been silent.
    """

    again: bool
    silence_s: float


class TopicRefused(NamedTuple):
    """Event: a topic is not used, because the device defines it differently."""

    reason: str


Heard: TypeAlias = TopicPayload | TopicsKnown | TopicRefused


def difference(wanted: Wanted, info: TopicInfo) -> str:
    """Return how the device's definition differs from ours, as text for people."""
    if wanted.type != info.type:
        return (
            f"the device says that topic '{info.name}' carries {info.type}, "
            f"the robot's profile says {wanted.type}"
        )
    return (
        f"the firmware's {info.type} is another one than ours: its md5 is {info.md5}, that of our "
        f"text {wanted.md5}. Put the .msg text of the firmware instead of this program's, "
        f"which is:\n"
        f"{wanted.text}"
    )
