"""A recording as tables in a folder, one file for each, with SI units in the headers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, closing
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from pirate_sm.core import effects as fx
from pirate_sm.core.effects import EFFECT_TABLES
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import SensorFrame
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.robot import RobotSpec
from pirate_sm.running.recording.format.engine_topics import Placed
from pirate_sm.running.recording.read.pieces import with_own_times
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.replay import Rerun, rerun
from pirate_sm.running.recording.signal_names import signal_names, slot_names

# --- rows -----------------------------------------------------------------------------------------


SIGNALS = "signals"
"""The table of the signals, one row for each frame."""

STATES, CONTROL = "states", "control"
"""The table of the robot's states, one row for each change, and its column of the active control,
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
            for table, row in _rows_of_effect(effect):
                yield TableRow(table, columns[table], (each.at_s, *row))


class _Actuated:
    """The states of a robot and the active control, and whether either has changed."""

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


def _rows_of_effect(effect: fx.Effect) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """Yield the rows of an effect without their times, each with its table."""
    if type(effect) in EFFECT_TABLES:
        table, columns = EFFECT_TABLES[type(effect)]
        rows, fields = fx.display_of(effect).rows, effect[: len(columns)]
        for row in (fields,) if rows is None else rows:
            yield table, tuple(_value(it) for it in row)


def _value(value: Any) -> Any:
    return " ".join(value) if isinstance(value, tuple) else value


# --- files ----------------------------------------------------------------------------------------


class TableFile(Protocol):
    """A table that is being written to its file."""

    def add(self, row: TableRow) -> None:
        """Add a row."""

    def close(self) -> None:
        """Complete the file."""


def write_files(
    recording: Recording,
    loaded: LoadedMission,
    folder: Path,
    suffix: str,
    begin: Callable[[Path, TableRow], TableFile],
) -> tuple[Path, ...]:
    """Write each topic of the recording to a file in the folder, and return the files.

    Signals are those that the engine computed from the raw values, one row for each frame.
    Positions of wheels are those shown to viewers: the simulator's true ones, if it knew them.

    Args:
        recording: The recording.
        loaded: Its mission.
        folder: The folder.
        suffix: The end of the files' names.
        begin: Opens the file of a table, given the table's first row.

    Raises:
        OSError: The folder cannot be written.
        RecordingError: The recording is damaged or empty.
    """
    files: dict[str, TableFile] = {}
    paths: list[Path] = []
    with ExitStack() as stack:
        for row in _all_rows(recording, loaded):
            if row.table not in files:
                folder.mkdir(parents=True, exist_ok=True)
                path = folder / f"{row.table}{suffix}"
                files[row.table] = stack.enter_context(closing(begin(path, row)))
                paths.append(path)
            files[row.table].add(row)
    if not paths:
        raise RecordingError(f"{shown(recording.path)} has no data for tables")
    return tuple(paths)


def _all_rows(recording: Recording, loaded: LoadedMission) -> Iterator[TableRow]:
    again = rerun(recording, loaded, every_signal=True)
    yield from rows_of(loaded.robot, again, recording.origin_s)
    for placed in recorded_places(recording, loaded.loaded_robot.profile.body):
        yield _place(placed, loaded)


def _place(it: Placed, loaded: LoadedMission) -> TableRow:
    """Return the position of each wheel; ``known`` is 1 if a simulator knew the true one.

    A robot in space has the third coordinate of each wheel too, the angle of its roll joint
    and the roll of each part.
    """
    wheels = loaded.loaded_robot.profile.body.wheels
    columns = [f"{wheel.name}_{axis}_m" for wheel in wheels for axis in "xy"]
    places = [*chain.from_iterable(it.wheels)]
    if it.space is not None:
        columns += [f"{wheel.name}_z_m" for wheel in wheels]
        columns += [f"roll_{name}_rad" for name in ("joint", *loaded.robot.parts)]
        places += [*it.space.z_m, *it.space.rolls_rad]
    return TableRow(PLACES, (TIME, KNOWN, *columns), (it.at_s, int(it.known), *places))
