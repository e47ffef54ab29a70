"""The topics that a robot's profile names, and what comes of asking a device for them."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from pirate_sm.rosserial.frames import LONGEST_PAYLOAD
from pirate_sm.rosserial.topics import Direction, TopicInfo


class Wanted(NamedTuple):
    """A topic that the robot's profile names.

    Attributes:
        direction: What the device does with it.
        text: The definition that we hold, for people.
        longest: Bytes of its longest payload.
        answers: It only ever answers what was written. So it does not show that the device goes
            on by itself, and is no end of a silence.
    """

    name: str
    type: str
    md5: str
    direction: Direction
    text: str = ""
    longest: int = LONGEST_PAYLOAD
    answers: bool = False


class TopicPayload(NamedTuple):
    """A payload on one of the wanted topics, in the order they were wanted."""

    which: int
    payload: bytes


class TopicsKnown(NamedTuple):
    """Reports that all wanted topics are known.

    Attributes:
        again: They had been before: the device had to be asked anew.
        silence_s: How long it had said nothing.
    """

    again: bool
    silence_s: float


class TopicRefused(NamedTuple):
    """Reports a topic that is not used because the device defines it differently."""

    reason: str


Heard: TypeAlias = TopicPayload | TopicsKnown | TopicRefused


def difference(wanted: Wanted, info: TopicInfo) -> str:
    """Return how the device's definition differs from ours, for a person to compare."""
    if wanted.type != info.type:
        return (
            f"the device says that topic '{info.name}' carries {info.type}, "
            f"the robot's profile says {wanted.type}"
        )
    return (
        f"the firmware's {info.type} is another one than ours: its md5 is {info.md5}, that of our "
        f"text {wanted.md5}. Put the .msg text of the firmware in place of ours, which is:\n"
        f"{wanted.text}"
    )
