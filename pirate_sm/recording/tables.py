"""A recording as tables, one for each topic, with SI units in the headers."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, suppress
from math import nan
from pathlib import Path
from typing import Any, TextIO

from pirate_sm.errors import RecordingError
from pirate_sm.expressions import NumberType
from pirate_sm.loading.folders import shown
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model import effects as fx
from pirate_sm.model.events import SensorFrame
from pirate_sm.recording.reader import Recording, Shown
from pirate_sm.recording.replay import Rerun, engine_of, rerun
from pirate_sm.recording.viewing import PLACES
from pirate_sm.units import DIMENSIONLESS, Dimension, format_quantity

Row = tuple[Any, ...]


def write_tables(recording: Recording, loaded: LoadedMission, folder: Path) -> tuple[Path, ...]:
    """Each topic of the recording is a CSV file in the folder; returns the files.

    Signals are those that the engine made of the boards' raw values, one line for each frame.
    Places of wheels are those that viewers were shown: the simulator's, where it knew.

    Raises:
        RecordingError: The recording is damaged or holds nothing, or the folder cannot be written.
            Then there are no tables.
    """
    tables: _Tables | None = None
    try:
        with ExitStack() as stack:
            tables = _Tables(loaded, folder, stack)
            _fill(tables, recording, loaded)
    except (OSError, RecordingError) as error:
        if tables is not None:
            tables.discard()
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"{folder} cannot be written: {error.strerror}") from None
    if not tables.files:
        raise RecordingError(f"{shown(recording.path)} holds nothing that a table could hold")
    return tables.files


def _fill(tables: _Tables, recording: Recording, loaded: LoadedMission) -> None:
    engine = engine_of(recording, loaded)
    for again in rerun(recording, loaded):
        if again.state is not None and isinstance(again.step.event, SensorFrame):
            tables.signals(again, engine.signals(again.state))
        for effect in again.step.effects:
            tables.effect(again.step.at_s, effect)
    for place in recording.shown(PLACES):
        tables.places(place)


class _Tables:
    """The files being written; one begins with its first line."""

    def __init__(self, loaded: LoadedMission, folder: Path, stack: ExitStack) -> None:
        self._robot = loaded.robot
        self._wheels = loaded.loaded_robot.profile.body.wheels
        self._folder = folder
        self._stack = stack
        self._writers: dict[str, Any] = {}
        self._paths: list[Path] = []

    @property
    def files(self) -> tuple[Path, ...]:
        return tuple(self._paths)

    def discard(self) -> None:
        """None of the files is left, nor their folder where nothing else is in it."""
        with suppress(OSError):
            for path in self._paths:
                path.unlink()
            self._folder.rmdir()

    def signals(self, again: Rerun, values: dict[str, float]) -> None:
        header = ["time_s", *(self._named(name) for name in values)]
        self._row("signals", header, (again.step.at_s, *values.values()))

    def _named(self, name: str) -> str:
        kind = self._robot.vocabulary.types[name]
        dimension = kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS
        return headed(name, dimension)

    def places(self, it: Shown) -> None:
        """Where each wheel was: true where ``known`` is 1, as a simulator knows it."""
        names = [wheel.name for wheel in self._wheels]
        columns = [f"{name}_{axis}_m" for name in names for axis in "xy"]
        row = (it.at_s, int(it.content["known"]), *(it.content.get(name, nan) for name in columns))
        self._row("places", ["time_s", "known", *columns], row)

    def effect(self, at_s: float, effect: fx.Effect) -> None:  # noqa: C901 - one case each
        """The effect is a line of its topic, where it has one."""
        header: Sequence[str] = effect._fields
        rows: Iterable[Row] = (effect,)
        match effect:
            case fx.Setpoints(setpoint_id, values):
                slots = self._robot.slots
                names = (f"{s.name}_{'rad' if s.unit == 'angle' else 'duty'}" for s in slots)
                topic, header, rows = (
                    "setpoints",
                    ("setpoint_id", *names),
                    ((setpoint_id, *values),),
                )
            case fx.StateChange(states, unconfirmed):
                topic, header = "states", (*self._robot.regions, "unconfirmed")
                rows = ((*states, " ".join(unconfirmed)),)
            case fx.WaitArmed(phase, triggers, conditions, deadline_s):
                topic, header = "waits", ("phase", "trigger", "condition", "deadline_s")
                armed = zip(triggers, conditions, strict=True)
                rows = ((phase, name, text, deadline_s) for name, text in armed)
            case fx.Ask(question, choices):
                topic, rows = "questions", ((question, " / ".join(choices)),)
            case fx.CommandStatus():
                topic = "commands"
            case fx.PhaseChange():
                topic = "phases"
            case fx.TriggerFired():
                topic = "triggers"
            case fx.Detected():
                topic = "detector"
            case fx.Environment():
                topic = "environment"
            case fx.Fault():
                topic = "faults"
            case fx.Log():
                topic = "log"
            case fx.Ended():
                topic = "end"
            case fx.WakeAt():
                return
        for row in rows:
            self._row(topic, ["time_s", *header], (at_s, *row))

    def _row(self, topic: str, header: list[str], row: Row) -> None:
        writer = self._writers.get(topic)
        if writer is None:
            self._folder.mkdir(parents=True, exist_ok=True)
            path = self._folder / f"{topic}.csv"
            file: TextIO = self._stack.enter_context(path.open("w", encoding="utf-8", newline=""))
            writer = self._writers[topic] = csv.writer(file)
            self._paths.append(path)
            writer.writerow(header)
        writer.writerow([_cell(value) for value in row])


def headed(name: str, dimension: Dimension) -> str:
    """A column's name with its SI unit, in characters that any program takes in a name."""
    unit = format_quantity(1.0, dimension).partition(" ")[2]
    unit = unit.replace("/", "_per_").replace("^", "").replace("*", "_")
    return f"{name}_{unit}" if unit else name


def _cell(value: Any) -> Any:
    """Return the value as a cell; unknown is an empty one, which pandas and Matlab read as NaN.

    Text from a mission must not begin a formula in a spreadsheet: an apostrophe before it makes
    it text there.
    """
    if isinstance(value, str) and value.startswith(_FORMULAS):
        return f"'{value}"
    return "" if isinstance(value, float) and value != value else value  # noqa: PLR0124


_FORMULAS = ("=", "+", "-", "@", "\t", "\r")
"""What a spreadsheet takes for the beginning of a formula (OWASP, CSV injection)."""
