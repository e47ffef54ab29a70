"""What happens in a run as rows of tables, with SI units in the headers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.expressions import NumberType
from pirate_sm.model import effects as fx
from pirate_sm.model.effect_words import choice_words
from pirate_sm.model.events import SensorFrame
from pirate_sm.recording.reader import with_own_times
from pirate_sm.recording.replay import Rerun
from pirate_sm.units import DIMENSIONLESS, Dimension, format_quantity

SIGNALS = "signals"
"""The table of what the engine made of the boards' raw values, one row for each frame."""

TIME = "time_s"
"""The first column of every table."""


class Row(NamedTuple):
    """One row of a table.

    Attributes:
        table: Name of the table.
        header: Names of the columns, the same in each row of the table.
        values: The values in the same order; NaN where a number is unknown.
    """

    table: str
    header: tuple[str, ...]
    values: tuple[Any, ...]


def signal_row(robot: RobotSpec, at_s: float, signals: Mapping[str, float]) -> Row:
    """Return the values of all signals at this time."""
    header = tuple(_named(robot, name) for name in signals)
    return Row(SIGNALS, (TIME, *header), (at_s, *signals.values()))


def rows_of(engine: Engine, again: Iterable[Rerun], origin_s: float = 0.0) -> Iterator[Row]:
    """Yield all rows of a run, from its steps given to the engine again.

    Args:
        engine: As it ran then.
        again: The steps.
        origin_s: When the run began, by the engine's clock; times of rows count from there.
    """
    for each in again:
        if each.state is not None and isinstance(each.step.event, SensorFrame):
            yield signal_row(engine.robot, each.at_s, engine.signals(each.state))
        for effect in with_own_times(each.step.effects, origin_s):
            yield from effect_rows(engine.robot, each.at_s, effect)


def effect_rows(robot: RobotSpec, at_s: float, effect: fx.Effect) -> Iterator[Row]:
    """Yield the effect as rows of its table; nothing where it has none."""
    make = _TABLES.get(type(effect))
    if make is not None:
        table, header, rows = make(robot, effect)
        for values in rows:
            yield Row(table, (TIME, *header), (at_s, *values))


def _named(robot: RobotSpec, name: str) -> str:
    kind = robot.vocabulary.types[name]
    return headed(name, kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS)


@cache
def headed(name: str, dimension: Dimension) -> str:
    """Return a column's name with its SI unit, in characters that any program takes in a name."""
    unit = format_quantity(1.0, dimension).partition(" ")[2]
    unit = unit.replace("/", "_per_").replace("^", "").replace("*", "_")
    return f"{name}_{unit}" if unit else name


_Made = tuple[str, Iterable[str], Iterable[tuple[Any, ...]]]


def _plain(table: str) -> Callable[[RobotSpec, Any], _Made]:
    """Return what makes a row with the fields of its effect as columns."""

    def make(robot: RobotSpec, it: Any) -> _Made:
        return table, it._fields, [tuple(it)]

    return make


def _setpoints(robot: RobotSpec, it: fx.Setpoints) -> _Made:
    names = (f"{s.name}_{'rad' if s.unit == 'angle' else 'duty'}" for s in robot.slots)
    return "setpoints", ("setpoint_id", *names), [(it.setpoint_id, *it.values)]


def _state(robot: RobotSpec, it: fx.StateChange) -> _Made:
    return "states", (*robot.regions, "unconfirmed"), [(*it.states, " ".join(it.unconfirmed))]


def _wait(robot: RobotSpec, it: fx.WaitArmed) -> _Made:
    rows = [
        (it.phase, name, text, it.deadline_s)
        for name, text in zip(it.triggers, it.conditions, strict=True)
    ]
    return "waits", ("phase", "trigger", "condition", "deadline_s"), rows


def _asked(robot: RobotSpec, it: fx.Ask) -> _Made:
    return "questions", ("question", "choices"), [(it.question, choice_words(it))]


_TABLES: dict[type, Callable[[RobotSpec, Any], _Made]] = {
    fx.Setpoints: _setpoints,
    fx.StateChange: _state,
    fx.CommandStatus: _plain("commands"),
    fx.PhaseChange: _plain("phases"),
    fx.WaitArmed: _wait,
    fx.TriggerFired: _plain("triggers"),
    fx.Detected: _plain("detector"),
    fx.Environment: _plain("environment"),
    fx.Fault: _plain("faults"),
    fx.Log: _plain("log"),
    fx.Ask: _asked,
    fx.Ended: _plain("end"),
}
