"""The events of a run as rows of tables, with SI units in the headers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from pirate_sm.core import effects as fx
from pirate_sm.core.effects import EFFECT_TABLES
from pirate_sm.core.events import SensorFrame
from pirate_sm.core.robot import RobotSpec
from pirate_sm.running.recording.column_names import signal_names, slot_names
from pirate_sm.running.recording.read.steps import with_own_times
from pirate_sm.running.recording.replay.replay import Rerun

SIGNALS = "signals"
"""The table of the signals, one row for each frame."""

STATES, CONTROL = "states", "control"
"""The table of the robot's states, one row for each change, and its column of the control in force,
as missions write it."""

PLACES, KNOWN = "places", "known"
"""The table of the wheels' positions, and its column that says whether they are true ones."""

SETPOINTS = "setpoints"
"""The table of the setpoints, one column for each slot."""

_DECLARED = dict(EFFECT_TABLES.values())

TABLES = (SIGNALS, SETPOINTS, STATES, *(name for name in _DECLARED if name != SETPOINTS))
"""Every table that the events of a run can fill."""

TIME = "time_s"
"""The first column of every table."""


class TableRow(NamedTuple):
    """One row of a table.

    Attributes:
        table: Name of the table.
        header: Names of the columns, the same in each row of the table.
        values: The values in the same order; NaN where a number is unknown.
    """

    table: str
    header: tuple[str, ...]
    values: tuple[Any, ...]


def headers(robot: RobotSpec) -> dict[str, tuple[str, ...]]:
    """Return the names of the columns of each table in :data:`TABLES`."""
    after_time: dict[str, tuple[str, ...]] = {
        **_DECLARED,
        SIGNALS: signal_names(robot),
        SETPOINTS: ("setpoint_id", *slot_names(robot)),
        STATES: (*robot.regions, "unconfirmed", CONTROL),
    }
    return {table: (TIME, *after_time[table]) for table in TABLES}


def rows_of(robot: RobotSpec, again: Iterable[Rerun], origin_s: float = 0.0) -> Iterator[TableRow]:
    """Yield all rows of a run from its replayed steps.

    Args:
        robot: The robot.
        again: The steps, replayed with every signal.
        origin_s: When the run began, by the engine's clock; times of rows count from there.
    """
    columns, actuated = headers(robot), _Actuated(robot)
    for each in again:
        for row in actuated.rows(each):
            yield TableRow(STATES, columns[STATES], (each.at_s, *row))
        if each.state is not None and isinstance(each.step.event, SensorFrame):
            yield TableRow(SIGNALS, columns[SIGNALS], (each.at_s, *each.state.sensing.shown))
        for effect in with_own_times(each.step.effects, origin_s):
            for table, row in _rows(effect):
                yield TableRow(table, columns[table], (each.at_s, *row))


class _Actuated:
    """The states of a robot and the control in force, and whether either has changed."""

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        self._control = 0
        self._states: fx.StateChange | None = None

    def rows(self, again: Rerun) -> Iterator[tuple[Any, ...]]:
        """Yield a row for each change in a step; of the control one after those of the states."""
        before, changes = self._control, 0
        if again.state is not None:
            self._control = again.state.robot.control
        for effect in again.step.effects:
            if isinstance(effect, fx.StateChange):
                self._states, changes = effect, changes + 1
                yield self._row(effect)
        if self._states is not None and self._control != before and not changes:
            yield self._row(self._states)

    def _row(self, states: fx.StateChange) -> tuple[Any, ...]:
        name = self._robot.control_name(self._control)
        return *states.states, " ".join(states.unconfirmed), name


def _rows(effect: fx.Effect) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """Yield the rows of an effect without their times, each with its table."""
    if type(effect) in EFFECT_TABLES:
        table, columns = EFFECT_TABLES[type(effect)]
        rows, fields = fx.display_of(effect).rows, effect[: len(columns)]
        for row in (fields,) if rows is None else rows:
            yield table, tuple(_cell(it) for it in row)


def _cell(value: Any) -> Any:
    return " ".join(value) if isinstance(value, tuple) else value
