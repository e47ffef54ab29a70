"""What was found out about a connected robot, as plain data, and the counts of its reports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from math import inf, isfinite, isnan, nan
from typing import Any, Literal, NamedTuple

from pirate_sm.core import units
from pirate_sm.core.events import SensorFrame
from pirate_sm.core.models import Board, Profile
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import FrameJudge
from pirate_sm.core.units import Dimension
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan

# --- facts ----------------------------------------------------------------------------------------


Level = Literal["no-go", "suspicious", "note"]

_SHOWN_IN: Mapping[units.Dimension, tuple[str, int]] = {
    units.ANGLE: ("deg", 1),
    units.CURRENT: ("mA", 0),
    units.TORQUE: ("mNm", 0),
}
"""The unit that people read a quantity in, and with how many decimals."""


class ExpectedRobot(NamedTuple):
    """The robot that is expected at the port."""

    profile: Profile
    robot: RobotSpec
    plan: LinkPlan


class DoctorFinding(NamedTuple):
    """Something that a person should know, in one sentence.

    Attributes:
        level: ``no-go``: no mission must start. ``suspicious``: one may. ``note``: all is well.
    """

    level: Level
    message: str


@dataclass(frozen=True)
class TopicFact:
    """A topic that the device offers, or should.

    Attributes:
        id: None where the device does not offer it.
        type: What the device calls its messages; likewise ``md5``.
        our_type: What the profile says; empty for a topic that we do not need.
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
        """Whether it is usable, or not needed."""
        if not self.our_type:
            return True
        return (self.type, self.md5) == (self.our_type, self.our_md5)


@dataclass(frozen=True)
class ChannelFact:
    """What one sensor showed.

    Attributes:
        raw: Its last value, in counts; None where none came. Likewise ``least`` and ``most``.
        value: The last value in SI; None where it has no signal or nothing came.
        shown: The value with its unit, as people read it.
        spikes: How many values could not be true.
        same: How often it showed one and the same value in a row.
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
    """What one board said.

    Attributes:
        per_s: Frames per second; ``expected_per_s`` by the profile's cycle.
        longest_gap_s: Between two of its frames.
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
    """What became of bytes and frames.

    Attributes:
        answer_s: From the opening of the port until the device introduced its topics.
        dropped: Bytes that belonged to no frame.
        unreadable: Payloads that were not what their type says.
        strange: Frames and readings of nothing that is known.
        damaged: Echoes of something else than was written.
        repeats: Frames written again.
        resets: How often the device had to be asked anew.
        time_requests: How often it asked the time.
        asked_ms: Round trips of requests for topics.
        echoed_ms: Round trips of arrays.
        stood_still_s: The longest time by which this computer woke too late.
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
    stood_still_s: float = 0.0


@dataclass(frozen=True)
class TurnFact:
    """Whether a wheel turned when it was asked to.

    Attributes:
        slot: What drives it.
        turned_rad: How far its sensor says that it did; None where it says nothing.
    """

    slot: str
    turned_rad: float | None
    turned: bool


@dataclass(frozen=True)
class MoveFact:
    """The test with setpoints.

    Attributes:
        sent: How many arrays; ``accepted`` of them were echoed as they were written.
    """

    sent: int
    accepted: int
    wheels: tuple[TurnFact, ...] = ()


@dataclass(frozen=True)
class Facts:
    """Everything that was found out.

    Attributes:
        strangers: Boards that report though the profile does not listen to them.
        words: What the firmware said, with its level as in ROS.
        refused: Why topics cannot be used.
        move: None where nothing was sent.
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
    findings: tuple[DoctorFinding, ...] = field(default=())

    @property
    def go(self) -> bool:
        """Whether a mission may start."""
        return not any(finding.level == "no-go" for finding in self.findings)

    def as_data(self) -> dict[str, Any]:
        """Mappings, lists, text and numbers; what no number can say is None."""
        data = asdict(self) | {"go": self.go}
        data["findings"] = [each._asdict() for each in self.findings]
        data["words"] = [{"level": level, "text": text} for level, text in self.words]
        plain: dict[str, Any] = _plain(data)
        return plain


def shown(value: float, dimension: units.Dimension) -> str:
    """Return the value with its unit as people read it."""
    if dimension in _SHOWN_IN:
        unit, decimals = _SHOWN_IN[dimension]
        return f"{value / units.UNITS[unit].value:z.{decimals}f} {unit}"
    if dimension in (units.ACCELERATION, units.DIMENSIONLESS):
        return units.format_quantity(round(value, 2) + 0.0, dimension)
    return units.format_quantity(float(f"{value:.3g}"), dimension)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not isfinite(value) else value


# --- counting reports -----------------------------------------------------------------------------


class ChannelRecord:
    """The values of one channel, whose index in the frame of its board is ``place``."""

    def __init__(self, place: int) -> None:
        self._place = place
        self.last, self.least, self.most = nan, inf, -inf
        self.count, self._run, self.longest_run = 0, 0, 0
        self._sum = 0.0

    def take(self, frame: SensorFrame) -> None:
        """Count the frame's value."""
        value = frame.values[self._place]
        if isnan(value):
            return
        self._run = self._run + 1 if value == self.last else 1
        self.longest_run = max(self.longest_run, self._run)
        self.last = value
        self.least, self.most = min(self.least, value), max(self.most, value)
        self.count += 1
        self._sum += value

    @property
    def mean(self) -> float:
        """Mean of the values; NaN if none came."""
        return self._sum / self.count if self.count else nan


class BoardRecord:
    """The reports of one board since ``began_s``."""

    def __init__(self, subject: ExpectedRobot, board: Board, began_s: float) -> None:
        robot = subject.robot
        self.board = board
        self.judge = FrameJudge(robot, board.id) if board.id in robot.boards else None
        self.channels = tuple(map(ChannelRecord, range(len(board.channels))))
        self._period_s = robot.link.period_s
        self.frames = 0
        self._heard_s = began_s
        self._gap_s = 0.0

    def take(self, frame: SensorFrame, now: float) -> None:
        """Count the frame."""
        self.frames += 1
        elapsed_s, self._heard_s = now - self._heard_s, now
        self._gap_s = max(self._gap_s, elapsed_s)
        for channel in self.channels:
            channel.take(frame)
        if self.judge is not None:
            self.judge.take(frame, max(elapsed_s, self._period_s), now)

    def gap_s(self, now: float) -> float:
        """Return the longest time without a frame, until now."""
        return max(self._gap_s, now - self._heard_s)


class Records:
    """The reports of all boards in the profile.

    Args:
        subject: The robot.
        now: Time at which counting begins.
    """

    def __init__(self, subject: ExpectedRobot, now: float) -> None:
        self._subject = subject
        self._began_s = now
        self.boards: Mapping[int, BoardRecord] = {
            board.id: BoardRecord(subject, board, now)
            for board in subject.profile.boards
            if board.id in subject.plan.channels
        }

    def take(self, frame: SensorFrame, now: float) -> None:
        """Count the frame."""
        if frame.board in self.boards:
            self.boards[frame.board].take(frame, now)

    def last(self, board: int, place: int) -> float:
        """Return the last count of a channel; NaN if none came."""
        return self.boards[board].channels[place].last if board in self.boards else nan

    def facts(self, now: float) -> tuple[BoardFact, ...]:
        """Return the facts counted until now."""
        profile = self._subject.profile
        turns = len(self.boards)
        if profile.serial is not None and profile.serial.state.layout == "value":
            turns = sum(len(record.channels) for record in self.boards.values())
        expected = 1.0 / (profile.link.cycle * turns) if turns else 0.0
        elapsed_s = max(now - self._began_s, 1e-3)
        return tuple(
            BoardFact(
                id=number,
                module=record.board.module,
                frames=record.frames,
                per_s=record.frames / elapsed_s,
                expected_per_s=expected,
                longest_gap_s=record.gap_s(now),
                channels=self._channels(record),
            )
            for number, record in self.boards.items()
        )

    def _channels(self, record: BoardRecord) -> tuple[ChannelFact, ...]:
        meaning = meanings(self._subject, record.board.id)
        return tuple(
            _fact(record, place, meaning.get(place)) for place in range(len(record.channels))
        )


Meaning = tuple[float, float, Dimension]
"""SI per count, the zero that is subtracted, and the dimension."""


def meanings(subject: ExpectedRobot, board: int) -> dict[int, Meaning]:
    """Return the meaning of the board's channels, by index in its frame."""
    spec = subject.robot.boards.get(board)
    if spec is None:
        return {}
    vocabulary, zeros = subject.robot.vocabulary, dict(spec.zeros)
    found: dict[int, Meaning] = {}
    for place, target, scale in spec.channels:
        dimension = vocabulary.dimension(vocabulary.numbers[target])
        found[place] = (scale, zeros.get(target, 0.0), dimension)
    return found


def _fact(board: BoardRecord, place: int, meaning: Meaning | None) -> ChannelFact:
    record, judge = board.channels[place], board.judge
    name, signal = board.board.channels[place].name, board.board.channels[place].signal or ""
    if not record.count:
        return ChannelFact(name, signal, None, None, None, None, "")
    value, text = None, ""
    if meaning is not None:
        scale, zero, dimension = meaning
        value = record.last * scale - zero
        text = shown(value, dimension)
    outside = judge.outside.get(place) if judge is not None else None
    return ChannelFact(
        name,
        signal,
        record.last,
        record.least,
        record.most,
        value,
        text,
        judge.spikes(place) if judge is not None else 0,
        record.longest_run,
        (outside,) if outside else (),
    )
