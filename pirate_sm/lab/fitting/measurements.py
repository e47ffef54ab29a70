"""What was measured: columns of numbers by their names, those of slip and friction, estimates."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import TextIOWrapper
from math import inf, isnan, nan
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Profile
from pirate_sm.core.on_disk import opened
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import rerun
from pirate_sm.running.recording.tables import SIGNALS, TIME, rows_of
from pirate_sm.simulation.arrays import Floats

# --- columns -------------------------------------------------------------------------------------


_SETPOINTS, _COMMANDS = "setpoints", "commands"

Columns = Mapping[str, Floats]
"""Columns of a table; all are of one length, and an unknown value is NaN."""


class SentCommand(NamedTuple):
    """A command that the mission gave.

    Attributes:
        name: Its name; ``place`` in the mission's file.
        nth: How often it had been given at this place before.
        from_s: When it was sent.
        until_s: When the next one was sent, or the recording ended.
    """

    name: str
    place: str
    nth: int
    from_s: float
    until_s: float


class MeasuredFile(NamedTuple):
    """What a file holds.

    Attributes:
        columns: Signals by their names.
        setpoints: Setpoints by the names of their slots; empty for a table.
        profile: Of the robot that was recorded; None for a table.
        recording: The file, if it is a recording.
        commands: What its mission commanded, in order.
        until_s: What is used of it.
    """

    columns: Columns
    setpoints: Columns = {}  # noqa: RUF012 - nothing writes to it
    profile: Profile | None = None
    recording: Path | None = None
    commands: tuple[SentCommand, ...] = ()
    until_s: float = inf

    def before(self, until_s: float) -> MeasuredFile:
        """Return what was measured up to a time."""
        return self._replace(
            columns=_until(self.columns, until_s),
            setpoints=_until(self.setpoints, until_s),
            until_s=until_s,
        )

    def with_columns(self, columns: Columns) -> MeasuredFile:
        """Return this with other signals of the same recording."""
        return self._replace(columns=_until(columns, self.until_s))


def _until(columns: Columns, until_s: float) -> Columns:
    if not columns:
        return columns
    kept = columns[TIME] <= until_s
    return {name: values[kept] for name, values in columns.items()}


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
    commands: list[tuple[float, str, str]] = []
    with recorded_mission(recording.header) as loaded:
        robot, profile = loaded.robot, loaded.loaded_robot.profile
        again = rerun(recording, loaded, every_signal=True)
        unknown = (nan,) * len(robot.slots)
        for row in rows_of(loaded.robot, again, recording.origin_s):
            if row.table == SIGNALS:
                rows.append(row.values)
            elif row.table == _SETPOINTS:
                sent.append((row.values[0], *row.values[2:]))
            elif row.table == _COMMANDS and row.values[2] == "sent":
                commands.append((row.values[0], row.values[1], row.values[4]))
    if not rows:
        raise UsageError(f"{path} holds no frame of a sensor: nothing can be fitted")
    sent += [(gap.from_s, *unknown) for gap in recording.gaps]  # others may have been sent in it
    sent.sort(key=itemgetter(0))
    signals = _named((TIME, *robot.vocabulary.numbers), rows)
    slots = (TIME, *(slot.name for slot in robot.slots))
    setpoints = _named(slots, sent) if sent else {}
    given = tuple(_given(commands, float(signals[TIME][-1])))
    return MeasuredFile(signals, setpoints, profile, path, given)


def _given(sent: Sequence[tuple[float, str, str]], end_s: float) -> Iterator[SentCommand]:
    """Yield the commands of a run by when each was sent."""
    times = [at_s for at_s, _, _ in sent] + [end_s]
    seen = Counter[tuple[str, str]]()
    for (from_s, *which), until_s in zip(sent, times[1:], strict=True):
        name, place = which
        yield SentCommand(name, place, seen[name, place], from_s, until_s)
        seen[name, place] += 1


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


# --- columns of slip and friction ----------------------------------------------------------------


WHEEL = "{}"
"""Stands for the number of a wheel in the name of a signal."""

_STEADY_S, _STEADY_READINGS = 0.5, 3
_SHARE, _SLIP_PLAY_M_S, _FRICTION_PLAY = 0.33, 0.002, 0.01


@dataclass(frozen=True)
class SlipSignalNames:
    """Names of signals, with ``{}`` for the number of a wheel.

    Attributes:
        slip: Slip speeds, m/s.
        friction: Friction coefficients in use; empty: from torque and normal force.
        known: Friction coefficients that are known only where a wheel surely slips.
        torque: Wheel torques, Nm.
        normal: Normal forces, N.
        radius_m: Of the wheels, with torques.
    """

    slip: str = "slip_speed_{}"
    friction: str = ""
    torque: str = "wheel_torque_{}"
    normal: str = "normal_force_{}"
    radius_m: float = 0.0
    known: str = "mu_{}"


def wheels_in(columns: Columns, signals: SlipSignalNames) -> list[str]:
    """Return the numbers of the wheels whose slip is in the columns, in their order.

    Raises:
        UsageError: There is none.
    """
    before, _, after = signals.slip.partition(WHEEL)
    pattern = re.compile(rf"{re.escape(before)}(\d+){re.escape(after)}(?:_[A-Za-z_]\w*)?")
    found = [match[1] for name in columns if (match := pattern.fullmatch(name))]
    if not found and WHEEL not in signals.slip and has(columns, [signals.slip]):
        return [""]
    if not found:
        raise UsageError(
            f"there is no signal '{signals.slip}' with the number of a wheel for {WHEEL}: "
            "name the signals of slip and friction with --slip and --friction"
        )
    return sorted(dict.fromkeys(found), key=int)


def steady(times_s: Floats, slip: Floats, friction: Floats) -> tuple[Floats, Floats]:
    """Return slip and friction where both have kept their values for half a second.

    Readings of a robot come one after the other: while a wheel speeds up or the robot bumps, its
    slip, its torque and the force on it belong to different moments.
    """
    known = np.isfinite(slip) & np.isfinite(friction)
    times_s, slip, friction = times_s[known], slip[known], friction[known]
    fresh = np.concatenate([[True], (np.diff(slip) != 0) | (np.diff(friction) != 0)])[: len(slip)]
    times_s, slip, friction = times_s[fresh], slip[fresh], friction[fresh]
    begins = np.searchsorted(times_s, times_s - _STEADY_S)
    kept = [
        end - begin >= _STEADY_READINGS
        and _keeps(slip[begin : end + 1], _SLIP_PLAY_M_S)
        and _keeps(friction[begin : end + 1], _FRICTION_PLAY)
        for end, begin in enumerate(begins)
    ]
    return slip[kept], friction[kept]


def _keeps(values: Floats, play: float) -> bool:
    """Return whether values differ by no more than a third of their size, or by some play."""
    return bool(np.ptp(values) <= max(_SHARE * abs(float(np.median(values))), play))


def slip_and_friction(
    columns: Columns, wheel: str, signals: SlipSignalNames
) -> tuple[Floats, Floats]:
    """Return slip speeds and friction coefficients of a wheel, in the order of time.

    Raises:
        UsageError: A signal is missing, or nothing is known of it.
    """
    slip = column(columns, signals.slip.replace(WHEEL, wheel))
    if signals.friction:
        return slip, column(columns, signals.friction.replace(WHEEL, wheel))
    torque = column(columns, signals.torque.replace(WHEEL, wheel))
    normal = column(columns, signals.normal.replace(WHEEL, wheel))
    if signals.radius_m <= 0:
        raise UsageError("friction from torques needs the radius of the wheels: --radius 24mm")
    pressed = np.where(normal > 0, normal, np.nan)
    friction: Floats = np.abs(torque) / signals.radius_m / pressed
    return slip, friction


# --- estimates -----------------------------------------------------------------------------------


_STRETCHES, DRAWS = 20, 200
"""Numbers of stretches of a run and of draws for intervals: neighbours are alike."""


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval.

    Attributes:
        value: NaN where it is unknown.
        low: Lower end; where only a bound is known, that.
        high: Upper end.
        reason: Why it is unknown; empty where it is known.
        draws: What stretches of the run say that are drawn at random. The same draw takes the
            same stretches for numbers of the same rows; of others they are of other times.
    """

    value: float = nan
    low: float = nan
    high: float = nan
    reason: str = ""
    draws: Floats = field(default_factory=lambda: np.empty(0), compare=False, repr=False)

    @property
    def known(self) -> bool:
        """Whether there is a value."""
        return not isnan(self.value)

    @property
    def likely(self) -> Floats:
        """Values as likely as each other; without draws all are the value."""
        return self.draws if len(self.draws) else np.full(DRAWS, self.value)


def estimate_of(
    rows: Floats, statistic: Callable[[Floats], float], shortest: int = 1, stream: int = 0
) -> Estimate:
    """Return a statistic with its interval, from draws of whole stretches of the run.

    Args:
        rows: What was measured, in the order of time.
        statistic: Returns the value that some of it gives; NaN if none.
        shortest: How many rows a stretch has at least.
        stream: Of the random stretches; runs that are compared have different ones.
    """
    random = np.random.default_rng(stream)
    stretches = np.array_split(rows, min(_STRETCHES, len(rows) // shortest))
    drawn: Floats = np.array(
        [
            statistic(np.concatenate([stretches[i] for i in picked]))
            for picked in random.integers(len(stretches), size=(DRAWS, len(stretches)))
        ]
    )
    known = np.isfinite(drawn).any()
    low, high = np.nanquantile(drawn, [0.025, 0.975]) if known else (nan, nan)
    return Estimate(statistic(rows), float(low), float(high), draws=drawn)
