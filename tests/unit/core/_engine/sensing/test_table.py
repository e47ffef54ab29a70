"""The table of signals of a robot."""

from __future__ import annotations

import pytest
from driving import NEWT, PIRATE

from pirate_sm.core._engine.sensing.known_signals import nothing_known
from pirate_sm.core._engine.sensing.signal_table import signal_table
from pirate_sm.core._loading.robot.loader import load_robot


@pytest.mark.parametrize("folder", [PIRATE, NEWT])
def test_the_rows_of_a_board_write_its_signals_and_what_all_boards_share(folder) -> None:
    robot = load_robot(folder).normal
    table = signal_table(robot)
    boards = sorted(robot.boards.values(), key=lambda board: board.position)

    for board, rows in zip(boards, table.boards, strict=True):
        written = [row[1] for row in (*rows.measured, *rows.derived)]
        shared = {robot.odometry, robot.speed, table.layout.loss}
        assert set(written) - shared == {*board.numbers, table.layout.heard + board.position}
        assert len(written) == len(set(written)) + max(len(board.wheels) - 1, 0)


@pytest.mark.parametrize("folder", [PIRATE, NEWT])
def test_constants_come_after_what_frames_change(folder) -> None:
    robot = load_robot(folder).normal
    table = signal_table(robot)

    cells = table.cells(nothing_known(robot))

    assert tuple(cells[table.layout.constants :]) == table.constants
    assert cells[table.layout.heard : table.layout.shares] == [float("-inf")] * len(robot.boards)
