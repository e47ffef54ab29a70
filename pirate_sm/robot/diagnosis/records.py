"""Counts the boards' reports and compares them with the plausible values of their sensors."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isnan, nan

from pirate_sm.core.events import BuiltInFault, SensorFrame
from pirate_sm.core.profile import Board
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import (
    Reading,
    WatchedSpec,
    WatchSpec,
    measured,
    nothing_known,
    sift,
    signal_table,
    unseen,
)
from pirate_sm.core.units import Dimension
from pirate_sm.robot.diagnosis.facts import BoardFact, ChannelFact, ExpectedRobot, shown


class ChannelRecord:
    """The values of one channel.

    Args:
        robot: The robot with the channel.
        place: Index of the channel in the frame of its board.
        watch: The sensor's limits; None if it has none.
    """

    def __init__(self, robot: RobotSpec, place: int, watch: WatchSpec | None) -> None:
        self._robot, self._place = robot, place
        self._watched = WatchedSpec(() if watch is None else (watch,))
        self._record = unseen(self._watched)
        self.last, self.least, self.most = nan, inf, -inf
        self.count, self._run, self.longest_run = 0, 0, 0
        self.outside = ""
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

    def judge(self, numbers: list[float], reading: Reading) -> None:
        """Compare the converted value with the sensor's limits."""
        self._record, reports = sift(
            self._robot.plausibility, self._watched, self._record, numbers, reading
        )
        for report in reports:
            if report.code == BuiltInFault.SENSOR_RANGE.code:
                self.outside = report.message

    @property
    def mean(self) -> float:
        """Mean of the values; NaN if none came."""
        return self._sum / self.count if self.count else nan

    @property
    def spikes(self) -> int:
        """Number of spikes that the engine would have hidden."""
        return sum(channel.hidden for channel in self._record.channels)


class BoardRecord:
    """The reports of one board since ``began_s``."""

    def __init__(self, subject: ExpectedRobot, board: Board, began_s: float) -> None:
        robot = subject.robot
        self.board = board
        self._spec = robot.boards.get(board.id)
        places = {number: place for place, number, _ in self._spec.channels} if self._spec else {}
        watched = self._spec.watched.sensors if self._spec else ()
        limits = {places[watch.number]: watch for watch in watched}
        self.channels = tuple(
            ChannelRecord(robot, place, limits.get(place)) for place in range(len(board.channels))
        )
        self._robot = robot
        self._cells = signal_table(robot).cells(nothing_known(robot))
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
        if self._spec is None:
            return
        cells = measured(self._robot, frame, self._cells)
        reading = Reading(self._cells, max(elapsed_s, self._period_s), now)
        for channel in self.channels:
            channel.judge(cells, reading)
        self._cells = cells

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
            _fact(channel.name, channel.signal or "", counted, meaning.get(place))
            for place, (channel, counted) in enumerate(
                zip(record.board.channels, record.channels, strict=True)
            )
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


def _fact(name: str, signal: str, record: ChannelRecord, meaning: Meaning | None) -> ChannelFact:
    if not record.count:
        return ChannelFact(name, signal, None, None, None, None, "")
    value, text = None, ""
    if meaning is not None:
        scale, zero, dimension = meaning
        value = record.last * scale - zero
        text = shown(value, dimension)
    return ChannelFact(
        name,
        signal,
        record.last,
        record.least,
        record.most,
        value,
        text,
        record.spikes,
        record.longest_run,
        (record.outside,) if record.outside else (),
    )
