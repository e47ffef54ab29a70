"""The engine's signals as arrays for compiled code, and back."""

from __future__ import annotations

import numpy as np

from pirate_sm.engine.gliding.glided import Glided, sensing_after
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.environment import Surveyed
from pirate_sm.engine.sensing.known_signals import Sensing
from pirate_sm.engine.sensing.sensor_memory import BoardMemory, SensorMemory
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.gliding import columns as col


class SignalTables:
    """The signals of one engine.

    Args:
        robot: The robot.

    Attributes:
        numbers: Signals, SI; NaN is unknown.
        heard_s: Per board when it last reported; `shares`, `angles`: per wheel, see
            :class:`~pirate_sm.engine.sensing.known_signals.Sensing`.
        memory: Per watched sensor what is remembered, see `columns.py`.
    """

    def __init__(self, robot: RobotSpec) -> None:
        boards = sorted(robot.boards.values(), key=lambda each: each.position)
        self._sensors = [len(board.watched.sensors) for board in boards]
        self.numbers: Floats = np.zeros(len(robot.vocabulary.numbers))
        self.heard_s: Floats = np.zeros(len(boards))
        self.shares: Floats = np.zeros(len(robot.wheels))
        self.angles: Floats = np.zeros(len(robot.wheels))
        self.memory: Floats = np.zeros((sum(self._sensors), col.MEMORY_COLUMNS))
        self._of: Sensing | None = None

    def take(self, sensing: Sensing) -> None:
        """Take the signals in; what has come from here is there already."""
        before = self._of
        if before is None or sensing.numbers is not before.numbers:
            self.numbers[:] = sensing.numbers
        if before is None or sensing.heard_s is not before.heard_s:
            self.heard_s[:] = sensing.heard_s
        if before is None or sensing.shares is not before.shares:
            self.shares[:] = sensing.shares
        if before is None or sensing.angles is not before.angles:
            self.angles[:] = sensing.angles
        if before is None or sensing.records is not before.records:
            self._take_records(sensing.records)
        self._of = sensing

    def _take_records(self, records: tuple[BoardMemory, ...]) -> None:
        rows = [
            (each.same, each.same_s, each.rest, each.rest_of_s, each.proven, each.away, 0.0)
            for record in records
            for each in record.channels
        ]
        self.memory[:] = np.array(rows, dtype=np.float64).reshape(self.memory.shape)

    def given(self, loss: float, surveyed: Surveyed) -> Glided:
        """Return the signals as the engine has them.

        Args:
            loss: Share of lost reports.
            surveyed: What the survey remembers.
        """
        assert self._of is not None  # they have been taken in before
        after = Glided(
            tuple(self.numbers.tolist()),
            tuple(self.heard_s.tolist()),
            tuple(self.shares.tolist()),
            tuple(self.angles.tolist()),
            self._records(self._of.records),
            loss,
            surveyed,
        )
        self._of = sensing_after(self._of, after)
        return after

    def _records(self, records: tuple[BoardMemory, ...]) -> tuple[BoardMemory, ...]:
        if not self.memory[:, col.M_CHANGED].any():
            return records
        rows, found, begin = self.memory.tolist(), [], 0
        for record, count in zip(records, self._sensors, strict=True):
            own = rows[begin : begin + count]
            begin += count
            changed = any(row[col.M_CHANGED] for row in own)
            found.append(_after(record, own) if changed else record)
        self.memory[:, col.M_CHANGED] = 0.0
        return tuple(found)


def _after(before: BoardMemory, rows: list[list[float]]) -> BoardMemory:
    """Return the memory of a board after quiet frames."""
    return before._replace(channels=tuple(map(_remembered, before.channels, rows)))


def _remembered(before: SensorMemory, row: list[float]) -> SensorMemory:
    """Return the memory of a sensor after quiet frames."""
    if not row[col.M_CHANGED]:
        return before
    same, same_s, rest, rest_of_s, proven, away, _ = row
    unasked = before.unasked and rest_of_s == before.rest_of_s
    now = same, same_s, rest, rest_of_s, bool(proven), int(away), unasked
    # Faster than replacing seven fields by name; this runs for every glide.
    return SensorMemory._make((*before[: -len(now)], *now))
