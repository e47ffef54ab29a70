"""Facts about a connected robot, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from math import isfinite
from typing import Any, Literal, NamedTuple

from pirate_sm.backends.serial.link.link_plan import LinkPlan
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model.profile import Profile
from pirate_sm.units import (
    ACCELERATION,
    ANGLE,
    CURRENT,
    DIMENSIONLESS,
    TORQUE,
    UNITS,
    Dimension,
    format_quantity,
)

Level = Literal["no-go", "suspicious", "note"]

_SHOWN_IN: Mapping[Dimension, tuple[str, int]] = {
    ANGLE: ("deg", 1),
    CURRENT: ("mA", 0),
    TORQUE: ("mNm", 0),
}
"""The unit in which people read a quantity, and the number of decimals."""


class Subject(NamedTuple):
    """The robot that is expected at the port."""

    profile: Profile
    robot: RobotSpec
    plan: LinkPlan


class Finding(NamedTuple):
    """A finding for people, in one sentence.

    Attributes:
        level: ``no-go``: no mission may start. ``suspicious``: one may. ``note``: all is well.
    """

    level: Level
    message: str


@dataclass(frozen=True)
class TopicFact:
    """A topic that the device offers or should offer.

    Attributes:
        id: Number of the topic; None if the device does not offer it.
        type: The device's message type; likewise ``md5``.
        our_type: The profile's message type; empty for a topic that we do not need.
        per_s: Messages per second.
    """

    name: str
    direction: str
    id: int | None
    type: str
    our_type: str
    md5: str
    our_md5: str
    per_s: float

    @property
    def agrees(self) -> bool:
        """Whether the topic is usable or not needed."""
        if not self.our_type:
            return True
        return (self.type, self.md5) == (self.our_type, self.our_md5)


@dataclass(frozen=True)
class ChannelFact:
    """The readings of one sensor.

    Attributes:
        raw: Its last count; None if none came. Likewise ``least`` and ``most``.
        value: The last value in SI; None if it has no signal or none came.
        shown: The value with its unit, for people.
        spikes: Number of implausible values.
        same: Length of the longest run of equal values.
        trouble: What is wrong with it, one sentence each.
    """

    name: str
    signal: str
    raw: float | None
    least: float | None
    most: float | None
    value: float | None
    shown: str
    spikes: int = 0
    same: int = 0
    trouble: tuple[str, ...] = ()


@dataclass(frozen=True)
class BoardFact:
    """The reports of one board.

    Attributes:
        per_s: Frames per second; ``expected_per_s`` is the rate by the profile's cycle.
        longest_gap_s: Longest time between two of its frames.
    """

    id: int
    module: str
    frames: int
    per_s: float
    expected_per_s: float
    longest_gap_s: float
    channels: tuple[ChannelFact, ...]


@dataclass(frozen=True)
class LinkFact:
    """Statistics of the link.

    Attributes:
        answer_s: Time from the opening of the port to the introduction of the topics.
        dropped: Bytes that belonged to no frame.
        unreadable: Payloads that do not fit their type.
        strange: Frames and readings of unknown topics, boards or channels.
        damaged: Echoes of values that were not written.
        repeats: Frames written again.
        resets: How often the device had to be asked anew.
        time_requests: How often it requested the time.
        asked_ms: Round trips of requests for topics.
        echoed_ms: Round trips of arrays.
    """

    answer_s: float
    bytes: int
    dropped: int
    unreadable: int
    strange: int
    damaged: int
    repeats: int
    resets: int
    time_requests: int
    asked_ms: tuple[float, ...]
    echoed_ms: tuple[float, ...]


@dataclass(frozen=True)
class TurnFact:
    """Whether a wheel turned on command.

    Attributes:
        slot: The slot that drives it.
        turned_rad: Its sensor's angle of turning; None without readings.
    """

    slot: str
    turned_rad: float | None
    turned: bool


@dataclass(frozen=True)
class MoveFact:
    """The result of the test with setpoints.

    Attributes:
        sent: Number of arrays; ``accepted`` is how many were echoed as written.
    """

    sent: int
    accepted: int
    wheels: tuple[TurnFact, ...] = ()


@dataclass(frozen=True)
class Facts:
    """All facts.

    Attributes:
        strangers: Boards that report but are not in the profile.
        words: Lines of the firmware's log, with levels as in ROS.
        refused: Why topics cannot be used.
        move: None if no setpoints were sent.
    """

    port: str
    robot: str
    baud: int
    listened_s: float
    topics: tuple[TopicFact, ...]
    boards: tuple[BoardFact, ...]
    strangers: tuple[int, ...]
    link: LinkFact
    words: tuple[tuple[int, str], ...]
    refused: tuple[str, ...]
    move: MoveFact | None = None
    findings: tuple[Finding, ...] = field(default=())

    @property
    def go(self) -> bool:
        """Whether a mission may start."""
        return not any(finding.level == "no-go" for finding in self.findings)

    def as_data(self) -> dict[str, Any]:
        """Return mappings, lists, text and numbers; NaN and infinity become None."""
        data = asdict(self) | {"go": self.go}
        data["findings"] = [each._asdict() for each in self.findings]
        data["words"] = [{"level": level, "text": text} for level, text in self.words]
        plain: dict[str, Any] = _plain(data)
        return plain


def shown(value: float, dimension: Dimension) -> str:
    """Return the value with its unit, for people."""
    if dimension in _SHOWN_IN:
        unit, decimals = _SHOWN_IN[dimension]
        return f"{value / UNITS[unit].value:z.{decimals}f} {unit}"
    if dimension in (ACCELERATION, DIMENSIONLESS):
        return format_quantity(round(value, 2) + 0.0, dimension)
    return format_quantity(float(f"{value:.3g}"), dimension)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not isfinite(value) else value
