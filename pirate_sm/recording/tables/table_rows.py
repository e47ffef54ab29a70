"""The events of a run as rows of tables, with SI units in the headers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model import effects as fx
from pirate_sm.model.effect_words import choice_words
from pirate_sm.model.events import SensorFrame
from pirate_sm.recording.column_names import signal_names, slot_names
from pirate_sm.recording.read.steps import with_own_times
from pirate_sm.recording.replay.replay import Rerun

SIGNALS = "signals"
"""The table of the signals, one row for each frame."""

TABLES = (
    *(SIGNALS, "setpoints", "states", "commands", "phases", "waits", "triggers", "detector"),
    *("environment", "faults", "log", "questions", "end"),
)
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


def signal_row(robot: RobotSpec, at_s: float, signals: Mapping[str, float]) -> TableRow:
    """Return the values of all signals at this time."""
    header = (TIME, *signal_names(robot, signals))
    return TableRow(SIGNALS, header, (at_s, *signals.values()))


def rows_of(engine: Engine, again: Iterable[Rerun], origin_s: float = 0.0) -> Iterator[TableRow]:
    """Yield all rows of a run from its replayed steps.

    Args:
        engine: The engine as in the run.
        again: The replayed steps.
        origin_s: When the run began, by the engine's clock; times of rows count from there.
    """
    for each in again:
        if each.state is not None and isinstance(each.step.event, SensorFrame):
            yield signal_row(engine.robot, each.at_s, engine.signals(each.state))
        for effect in with_own_times(each.step.effects, origin_s):
            yield from effect_rows(engine.robot, each.at_s, effect)


def effect_rows(robot: RobotSpec, at_s: float, effect: fx.Effect) -> Iterator[TableRow]:
    """Yield the effect as rows of its table; nothing if it has none."""
    made = _table(robot, effect)
    if made is not None:
        for values in made.rows:
            yield TableRow(made.table, (TIME, *made.header), (at_s, *values))


class _Made(NamedTuple):
    """Rows of one table without their times."""

    table: str
    header: tuple[str, ...]
    rows: Iterable[tuple[Any, ...]]


def _table(robot: RobotSpec, effect: fx.Effect) -> _Made | None:  # noqa: C901 - one case each
    match effect:
        case fx.Setpoints(setpoint_id, values):
            header = ("setpoint_id", *slot_names(robot))
            return _Made("setpoints", header, [(setpoint_id, *values)])
        case fx.StateChange(states, unconfirmed):
            header = (*robot.regions, "unconfirmed")
            return _Made("states", header, [(*states, " ".join(unconfirmed))])
        case fx.WaitArmed(phase, triggers, conditions, deadline_s):
            armed = zip(triggers, conditions, strict=True)
            rows = [(phase, name, text, deadline_s) for name, text in armed]
            return _Made("waits", ("phase", "trigger", "condition", "deadline_s"), rows)
        case fx.Ask(question):
            return _Made("questions", effect._fields, [(question, choice_words(effect))])
        case fx.CommandStatus():
            return _plain("commands", effect)
        case fx.PhaseChange():
            return _plain("phases", effect)
        case fx.TriggerFired():
            return _plain("triggers", effect)
        case fx.Detected():
            return _plain("detector", effect)
        case fx.Environment():
            return _plain("environment", effect)
        case fx.Fault():
            return _plain("faults", effect)
        case fx.Log():
            return _plain("log", effect)
        case fx.Ended():
            return _plain("end", effect)
        case fx.WakeAt():
            return None


def _plain(table: str, effect: fx.Effect) -> _Made:
    """Return the row with the fields of an effect as columns."""
    return _Made(table, effect._fields, [tuple(effect)])
