"""Judge the frames of one board by themselves, as they come from a robot that runs no mission."""

from __future__ import annotations

from collections.abc import Sequence

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.board_spec import WatchedSpec
from pirate_sm.core._engine.sensing.evaluator import run
from pirate_sm.core._engine.sensing.known_signals import nothing_known
from pirate_sm.core._engine.sensing.plausibility import Reading, sift, unseen
from pirate_sm.core._engine.sensing.signal_table import signal_table
from pirate_sm.core._model.events import SensorFrame
from pirate_sm.core._model.faults import BuiltInFault


class FrameJudge:
    """Compares each sensor of a board with its limits, whatever the others show.

    Args:
        robot: The robot.
        board: Number of the board.

    Attributes:
        outside: What was last said about a value outside its limits, by index in the frame.
    """

    def __init__(self, robot: RobotSpec, board: int) -> None:
        self._robot, spec = robot, robot.boards[board]
        places = {number: place for place, number, _ in spec.channels}
        self._watched = {places[each.number]: WatchedSpec((each,)) for each in spec.watched.sensors}
        self._memories = {place: unseen(each) for place, each in self._watched.items()}
        self._cells = signal_table(robot).cells(nothing_known(robot))
        self.outside: dict[int, str] = {}

    def take(self, frame: SensorFrame, elapsed_s: float, now_s: float) -> None:
        """Judge a frame that comes so long after the one before."""
        cells = measured(self._robot, frame, self._cells)
        reading = Reading(self._cells, elapsed_s, now_s)
        for place, watched in sorted(self._watched.items()):
            self._memories[place], reports = sift(
                self._robot.plausibility, watched, self._memories[place], cells, reading
            )
            for report in reports:
                if report.code == BuiltInFault.SENSOR_RANGE.code:
                    self.outside[place] = report.message
        self._cells = cells

    def spikes(self, place: int) -> int:
        """Return how many spikes of a channel the engine would have hidden."""
        memory = self._memories.get(place)
        return 0 if memory is None else sum(sensor.hidden for sensor in memory.channels)


def measured(robot: RobotSpec, frame: SensorFrame, cells: Sequence[float]) -> list[float]:
    """Return the cells, with the signals that a board of the robot measures; SI units."""
    table, measured = signal_table(robot), list(cells)
    rows = table.boards[robot.boards[frame.board].position].measured
    run(rows, table.lists, measured, cells, frame.values, 0.0, 0.0)
    return measured
