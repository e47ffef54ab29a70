"""The engine's signals as arrays for compiled code, and back."""

from __future__ import annotations

import numpy as np

from pirate_sm.engine.gliding.glided import Glided, sensing_after
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.environment import Surveyed
from pirate_sm.engine.sensing.known_signals import MotorRequest, Sensing, nothing_known
from pirate_sm.engine.sensing.sensor_memory import BoardMemory, SensorMemory
from pirate_sm.engine.signals.table import signal_table
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.gliding import columns as col


class SignalTables:
    """The signals of one engine.

    Args:
        robot: The robot.

    Attributes:
        signals: The cells, see :class:`~pirate_sm.engine.signals.table.Layout`; then per watched
            sensor what is remembered, see `columns.py`.
        setpoints: Of these the setpoints in force and those last sent, a row each.
    """

    def __init__(self, robot: RobotSpec) -> None:
        boards = sorted(robot.boards.values(), key=lambda each: each.position)
        self._sensors = [len(board.watched.sensors) for board in boards]
        table, memory = signal_table(robot), sum(self._sensors) * col.MEMORY_COLUMNS
        cells = table.cells(nothing_known(robot))
        self.signals: Floats = np.array([*cells, *[0.0] * memory])
        at = self._layout = table.layout
        self._numbers, self._heard_s, self._shares, self._angles, _, setpoints, _ = np.split(
            self.signals, [at.heard, at.shares, at.angles, at.loss, at.force, at.out]
        )
        self.setpoints: Floats = setpoints.reshape(2, -1)
        self._memory: Floats = self.signals[len(cells) :].reshape(-1, col.MEMORY_COLUMNS)
        self._of: Sensing | None = None

    def take(self, sensing: Sensing) -> None:
        """Take the signals in; what has come from here is there already."""
        before = self._of
        if before is None or sensing.numbers is not before.numbers:
            self._numbers[:] = sensing.numbers
        if before is None or sensing.heard_s is not before.heard_s:
            self._heard_s[:] = sensing.heard_s
        if before is None or sensing.shares is not before.shares:
            self._shares[:] = sensing.shares
        if before is None or sensing.angles is not before.angles:
            self._angles[:] = sensing.angles
        if before is None or sensing.records is not before.records:
            self._take_records(sensing.records)
        self.signals[self._layout.loss] = sensing.loss
        self._of = sensing

    def _take_records(self, records: tuple[BoardMemory, ...]) -> None:
        rows = [
            (each.same, each.same_s, each.rest, each.rest_of_s, each.proven, each.away, 0.0)
            for record in records
            for each in record.channels
        ]
        self._memory[:] = np.array(rows, dtype=np.float64).reshape(self._memory.shape)

    def given(
        self,
        asked: MotorRequest,
        checked_s: float,
        wake_s: float,
        word_s: float,
        surveyed: Surveyed,
    ) -> Glided:
        """Return the signals as the engine has them.

        Args:
            asked: What the motors have been asked.
            checked_s: When silent boards were looked for.
            wake_s: When the engine asks to be called.
            word_s: Until when the detector's word is valid.
            surveyed: What the survey remembers.
        """
        assert self._of is not None  # they have been taken in before
        after = Glided(
            tuple(self._numbers.tolist()),
            tuple(self._heard_s.tolist()),
            tuple(self._shares.tolist()),
            tuple(self._angles.tolist()),
            self._records(self._of.records),
            *(asked, float(self.signals[self._layout.loss])),
            *(checked_s, wake_s, word_s),
            surveyed,
        )
        self._of = sensing_after(self._of, after)
        return after

    def _records(self, records: tuple[BoardMemory, ...]) -> tuple[BoardMemory, ...]:
        if 1.0 not in self._memory[:, col.M_CHANGED].tolist():
            return records
        rows, found, begin = self._memory.tolist(), [], 0
        for record, count in zip(records, self._sensors, strict=True):
            own = rows[begin : begin + count]
            begin += count
            changed = any(row[col.M_CHANGED] for row in own)
            found.append(_after(record, own) if changed else record)
        self._memory[:, col.M_CHANGED] = 0.0
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
