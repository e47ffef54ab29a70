"""A robot's boards, wheels and sensors as arrays for compiled code."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.plausibility_spec import WatchSpec
from pirate_sm.engine.signals.table import Row, signal_table
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.sensors import BoardChannels


class RobotTables(NamedTuple):
    """The tables, in the order of the compiled functions' arguments; see `columns.py`."""

    boards: Ints
    rows: Ints
    lists: Ints
    sensors: Floats
    robot: Floats


def robot_tables(robot: RobotSpec, reporting: Sequence[BoardChannels]) -> RobotTables | None:
    """Return the tables of a robot; None if the boards that report are not those it knows."""
    channels = {each.board: each for each in reporting}
    if channels.keys() != robot.boards.keys():
        return None
    specs = sorted(robot.boards.values(), key=lambda each: each.position)
    if any(channels[each.id].last - channels[each.id].first < each.length for each in specs):
        return None
    table = signal_table(robot)
    rows: list[Row] = []
    sensors: list[tuple[float, ...]] = []
    boards = []
    for board, sections in zip(specs, table.boards, strict=True):
        ends = [len(rows)]
        for section in sections:
            rows += section
            ends.append(len(rows))
        own = [_sensor(each) for each in board.watched.sensors]
        first, last = channels[board.id].first, channels[board.id].last
        boards.append((*ends, len(sensors), len(sensors) + len(own), first, last - first))
        sensors += own
    return RobotTables(
        np.array(boards, dtype=np.int64).reshape(-1, col.BOARD_COLUMNS),
        np.array(rows, dtype=np.int64).reshape(-1, 5),
        np.array(table.lists, dtype=np.int64),
        np.array(sensors, dtype=np.float64).reshape(-1, 10),
        _constants(robot, table.layout.loss),
    )


def _sensor(watch: WatchSpec) -> tuple[float, ...]:
    return (
        *(watch.number, watch.low, watch.high, watch.rate, watch.slack, watch.moved),
        *(watch.slot, watch.least_duty, watch.load, watch.full_load),
    )


def _constants(robot: RobotSpec, loss: int) -> Floats:
    found = np.zeros(col.ROBOT_ENTRIES)
    found[col.R_PERIOD_S] = robot.link.period_s
    found[col.R_SILENT_AFTER_S] = robot.link.silent_after_s
    found[col.R_SETTLE_S] = robot.plausibility.settle_s
    found[col.R_UNLOADED] = robot.plausibility.unloaded
    found[col.R_STUCK_AFTER_S] = robot.plausibility.stuck_after_s
    found[col.R_LOSS] = loss
    found[col.R_STALE_AFTER_S] = robot.link.stale_after_s
    found[col.R_LISTEN_EVERY_S] = robot.link.listen_every_s
    return found
