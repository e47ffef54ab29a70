"""A robot's boards, wheels and sensors as arrays for compiled code."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.board_spec import BoardSpec, Vector, WheelSpec
from pirate_sm.engine.sensing.plausibility_spec import WatchSpec
from pirate_sm.engine.sensing.report_loss import GAIN
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.sensors import BoardChannels

Row = tuple[float, ...]


class RobotTables(NamedTuple):
    """The tables, in the order of the compiled functions' arguments; see `columns.py`."""

    boards: Ints
    channels: Floats
    derived: Floats
    wheels: Floats
    own: Floats
    sensors: Floats
    robot: Floats


def robot_tables(robot: RobotSpec, reporting: Sequence[BoardChannels]) -> RobotTables | None:
    """Return the tables of a robot; None if the boards that report are not those it knows."""
    rows = {each.board: each for each in reporting}
    if rows.keys() != robot.boards.keys():
        return None
    specs = sorted(robot.boards.values(), key=lambda each: each.position)
    if any(rows[each.id].last - rows[each.id].first < each.length for each in specs):
        return None
    channels, derived, own, sensors = _Rows(), _Rows(), _Rows(), _Rows()
    boards = []
    for board in specs:
        parts = (
            channels.add(_channels(board)),
            derived.add(_derived(board)),
            own.add(_wheel(robot, each) for each in board.wheels),
            sensors.add(_sensor(each) for each in board.watched.sensors),
        )
        first, last = rows[board.id].first, rows[board.id].last
        boards.append((*(at for part in parts for at in part), first, last - first))
    wheels = [_wheel(robot, each) for each in robot.wheels]
    return RobotTables(
        np.array(boards, dtype=np.int64).reshape(-1, col.BOARD_COLUMNS),
        channels.table(4),
        derived.table(7),
        np.array(wheels, dtype=np.float64).reshape(-1, 6),
        own.table(6),
        sensors.table(10),
        _constants(robot),
    )


class _Rows:
    """Rows of a table, added board by board."""

    def __init__(self) -> None:
        self._rows: list[Row] = []

    def add(self, rows: Iterable[Row]) -> tuple[int, int]:
        """Add rows; return where they begin and end."""
        begin = len(self._rows)
        self._rows += rows
        return begin, len(self._rows)

    def table(self, columns: int) -> Floats:
        """Return the table."""
        return np.array(self._rows, dtype=np.float64).reshape(-1, columns)


def _channels(board: BoardSpec) -> list[Row]:
    zeros = dict(board.zeros)
    return [(place, at, scale, zeros.get(at, 0.0)) for place, at, scale in board.channels]


def _derived(board: BoardSpec) -> list[Row]:
    return [
        *((col.RATE, source, 0, 0, 0, 0, target) for source, target in board.rates),
        *(
            (col.TORQUE, source, slot, 0, scale, 0, target)
            for source, slot, scale, target in board.torques
        ),
        *((_kind(each), *each.sources, 0, 0, each.target) for each in board.vectors),
        *(
            (col.DIAMETER, apex, 0, 0, length_m, wheels_m, target)
            for apex, length_m, wheels_m, target in board.diameters
        ),
    ]


def _kind(vector: Vector) -> int:
    match vector.how:
        case "roll":
            return col.ROLL
        case "pitch":
            return col.PITCH
        case "norm":
            return col.NORM


def _wheel(robot: RobotSpec, wheel: WheelSpec) -> Row:
    board = dict(zip([each.place for each in robot.wheels], robot.wheel_boards, strict=True))
    return (*wheel[:5], board[wheel.place])


def _sensor(watch: WatchSpec) -> Row:
    return (
        *(watch.number, watch.low, watch.high, watch.rate, watch.slack, watch.moved),
        *(watch.slot, watch.least_duty, watch.load, watch.full_load),
    )


def _constants(robot: RobotSpec) -> Floats:
    found = np.zeros(col.ROBOT_ENTRIES)
    found[col.R_PERIOD_S] = robot.link.period_s
    found[col.R_SILENT_AFTER_S] = robot.link.silent_after_s
    found[col.R_SETTLE_S] = robot.plausibility.settle_s
    found[col.R_UNLOADED] = robot.plausibility.unloaded
    found[col.R_STUCK_AFTER_S] = robot.plausibility.stuck_after_s
    found[col.R_ODOMETRY] = robot.odometry
    found[col.R_SPEED] = robot.speed
    found[col.R_LOSS_GAIN] = GAIN
    found[col.R_STALE_AFTER_S] = robot.link.stale_after_s
    found[col.R_LISTEN_EVERY_S] = robot.link.listen_every_s
    return found
