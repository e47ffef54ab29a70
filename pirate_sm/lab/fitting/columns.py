"""Columns of numbers by their names, from recordings and from tables, without their units."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from io import TextIOWrapper
from math import nan
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import opened
from pirate_sm.core.profile import Profile
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.replay.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay.replay import rerun
from pirate_sm.running.recording.tables.table_rows import SIGNALS, TIME, rows_of
from pirate_sm.simulation.arrays import Floats

_SETPOINTS = "setpoints"

Columns = Mapping[str, Floats]
"""Columns of a table; all are of one length, and NaN stands where a value is unknown."""


class MeasuredFile(NamedTuple):
    """What a file holds.

    Attributes:
        columns: Signals by their names.
        setpoints: Setpoints by the names of their slots; empty for a table.
        profile: Of the robot that was recorded; None for a table.
        recording: The file, if it is a recording.
    """

    columns: Columns
    setpoints: Columns = {}  # noqa: RUF012 - nothing writes to it
    profile: Profile | None = None
    recording: Path | None = None


def read_measured(path: Path) -> MeasuredFile:
    """Return the signals of a recording, or the columns of a table (``.csv``), in SI units.

    A recording's columns have the names of its signals, a table's those of its header.

    Raises:
        RecordingError: The recording cannot be read.
        UsageError: The table cannot be read.
    """
    return MeasuredFile(_table(path)) if path.suffix == ".csv" else _recorded(path)


def column(columns: Columns, name: str) -> Floats:
    """Return a column; its name may lack the unit that it ends with.

    Raises:
        UsageError: There is none.
    """
    found = columns.get(name)
    if found is None:
        found = next((each for key, each in columns.items() if key.startswith(f"{name}_")), None)
    if found is None:
        close = nearest(name, list(columns))
        hint = f"did you mean '{close}'?" if close else f"expected {one_of(sorted(columns)[:12])}"
        raise UsageError(f"there is no signal '{name}': {hint}")
    return found


def has(columns: Columns, names: Iterable[str]) -> bool:
    """Return whether there is a column for each of the names."""
    return all(
        name in columns or any(key.startswith(f"{name}_") for key in columns) for name in names
    )


def _recorded(path: Path) -> MeasuredFile:
    recording = read_recording(path)
    rows: list[tuple[float, ...]] = []
    sent: list[tuple[float, ...]] = []
    with recorded_mission(recording.header) as loaded:
        robot, profile = loaded.robot, loaded.loaded_robot.profile
        again = rerun(recording, loaded, every_signal=True)
        unknown = (nan,) * len(robot.slots)
        for row in rows_of(loaded.robot, again, recording.origin_s):
            if row.table == SIGNALS:
                rows.append(row.values)
            elif row.table == _SETPOINTS:
                sent.append((row.values[0], *row.values[2:]))
    if not rows:
        raise UsageError(f"{path} holds no frame of a sensor: nothing can be fitted")
    sent += [(gap.from_s, *unknown) for gap in recording.gaps]  # others may have been sent in it
    sent.sort(key=itemgetter(0))
    signals = _named((TIME, *robot.vocabulary.numbers), rows)
    slots = (TIME, *(slot.name for slot in robot.slots))
    return MeasuredFile(signals, _named(slots, sent) if sent else {}, profile, path)


def _named(names: Sequence[str], rows: Sequence[tuple[float, ...]]) -> Columns:
    values = np.array([row[: len(names)] for row in rows], dtype=np.float64)
    return dict(zip(names, values.T, strict=True))


def _table(path: Path) -> Columns:
    try:
        with TextIOWrapper(opened(path), encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
        values = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{path} cannot be read: {error}") from None
    except ValueError as error:
        raise UsageError(f"{path} is not a table of numbers with a header: {error}") from None
    if not len(values):
        raise UsageError(f"{path} has no rows")
    return dict(zip(header, values.T, strict=True))
