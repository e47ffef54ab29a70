"""A robot's boards, wheels and sensors as arrays for compiled code."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import Row, signal_table
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.sensors import BoardChannels


class RobotTables(NamedTuple):
    """The tables, in the order of the compiled functions' arguments; see `columns.py`."""

    boards: Ints
    rows: Ints
    lists: Ints
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
    boards = []
    for board, own in zip(specs, table.boards, strict=True):
        begin, (first, last) = len(rows), channels[board.id][1:3]
        rows += own.whole
        boards.append((begin, begin + len(own.measured), len(rows), first, last - first))
    return RobotTables(
        np.array(boards, dtype=np.int64).reshape(-1, col.BOARD_COLUMNS),
        np.array(rows, dtype=np.int64).reshape(-1, 5),
        np.array(table.lists, dtype=np.int64),
        _constants(robot, table.layout.loss),
    )


def _constants(robot: RobotSpec, loss: int) -> Floats:
    found = np.zeros(col.ROBOT_ENTRIES)
    found[col.R_PERIOD_S] = robot.link.period_s
    found[col.R_SILENT_AFTER_S] = robot.link.silent_after_s
    found[col.R_LOSS] = loss
    found[col.R_STALE_AFTER_S] = robot.link.stale_after_s
    found[col.R_LISTEN_EVERY_S] = robot.link.listen_every_s
    return found
