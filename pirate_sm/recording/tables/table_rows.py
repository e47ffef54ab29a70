"""The events of a run as rows of tables, with SI units in the headers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model import effects as fx
from pirate_sm.model.effect_words import choice_words
from pirate_sm.model.events import SensorFrame
from pirate_sm.recording.column_names import signal_names, slot_names
from pirate_sm.recording.read.steps import with_own_times
from pirate_sm.recording.replay.replay import Rerun

SIGNALS = "signals"
"""The table of the signals, one row for each frame."""

STATES, CONTROL = "states", "control"
"""The table of the robot's states, one row for each change, and its column of the control in force,
as missions write it."""

PLACES, KNOWN = "places", "known"
"""The table of the wheels' positions, and its column that says whether they are true ones."""

TABLES = (
    *(SIGNALS, "setpoints", STATES, "commands", "phases", "waits", "triggers", "detector"),
    *("environment", "faults", "log", "questions", "end"),
)
"""Every table that the events of a run can fill."""

TIME = "time_s"
"""The first column of every table."""

_COMMAND = fx.CommandStatus._fields[:-1]
"""The columns of commands; the reason says what was not met."""


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
        SIGNALS: signal_names(robot),
        "setpoints": ("setpoint_id", *slot_names(robot)),
        STATES: (*robot.regions, "unconfirmed", CONTROL),
        "commands": _COMMAND,
        "phases": fx.PhaseChange._fields,
        "waits": ("phase", "trigger", "condition", "deadline_s"),
        "triggers": fx.TriggerFired._fields,
        "detector": fx.Detected._fields,
        "environment": fx.Environment._fields,
        "faults": fx.Fault._fields,
        "log": fx.Log._fields,
        "questions": fx.Ask._fields,
        "end": fx.Ended._fields,
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
            table, rows = _rows(effect)
            for row in rows:
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


def _rows(effect: fx.Effect) -> tuple[str, Iterable[tuple[Any, ...]]]:  # noqa: C901 - one case each
    """Return the table of an effect and its rows without their times."""
    match effect:
        case fx.Setpoints(setpoint_id, values):
            return "setpoints", [(setpoint_id, *values)]
        case fx.WaitArmed(phase, triggers, conditions, deadline_s):
            armed = zip(triggers, conditions, strict=True)
            return "waits", [(phase, name, text, deadline_s) for name, text in armed]
        case fx.Ask(question):
            return "questions", [(question, choice_words(effect))]
        case fx.CommandStatus():
            return "commands", [effect[: len(_COMMAND)]]
        case fx.PhaseChange():
            return "phases", [effect]
        case fx.TriggerFired():
            return "triggers", [effect]
        case fx.Detected():
            return "detector", [effect]
        case fx.Environment():
            return "environment", [effect]
        case fx.Fault():
            return "faults", [(*effect[:-1], " ".join(effect.of))]
        case fx.Log():
            return "log", [effect]
        case fx.Ended():
            return "end", [effect]
        case fx.StateChange() | fx.WakeAt():
            return "", ()
