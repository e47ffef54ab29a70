"""Predicts the second half of a recording by robots that the first half leaves possible.

Each robot of the sample runs the recorded mission in the simulator with a seed of its own, so
that bands hold the noise of a run as well as what is unknown of the robot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import ceil, nan
from multiprocessing import get_context
from pathlib import Path
from signal import SIG_IGN, SIGINT, signal
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from pirate_sm.api.running import run
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.models import SIMULATORS
from pirate_sm.lab.fitting.measurements import (
    Columns,
    MeasuredFile,
    SentCommand,
    SlipSignalNames,
    column,
    read_measured,
    wheels_in,
)
from pirate_sm.lab.fitting.robot_numbers import load_signals, robot_numbers
from pirate_sm.lab.fitting.twin_file import twin_text
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission

SHARE = 0.9
"""Share of the recorded values that bands are to hold."""

_SEEDS_FROM = 1000
"""The seeds of predicting runs, so that none is that of the recording by accident."""

_LEAST_READINGS = 3
_LEAST_SHARE = 0.5
"""Of the robots that give the command, too: what becomes of fewer is another story."""

_KEPT_OPTIONS = ("defects", "ruler", "fidelity", "start_jitter_m", "diameter_jitter_m")
_KINDS = DURATION, LOAD, SLIP = ("duration", "load", "slip")
UNITS = {DURATION: "s", LOAD: "Nm", SLIP: "m/s"}


class CommandValue(NamedTuple):
    """Something that is measured of a command.

    Attributes:
        kind: How long it was the last one given, mean load of a board's motors or mean slip speed
            of the wheels meanwhile.
        board: Of the load.
        command: Its name; ``place`` in the file, and how often it was given there before.
    """

    kind: str
    board: str
    command: str
    place: str
    nth: int


class Predicted(NamedTuple):
    """A quantity, the band that is predicted, and what was recorded.

    Attributes:
        from_s: When the command was given, in the recording.
    """

    quantity: CommandValue
    from_s: float
    low: float
    high: float
    recorded: float

    @property
    def held(self) -> bool:
        """Whether the band holds what was recorded."""
        return self.low <= self.recorded <= self.high

    @property
    def off(self) -> float:
        """How far the recorded value is from the middle, in halves of the band."""
        return abs(2 * self.recorded - self.low - self.high) / (self.high - self.low)

    def widened(self, factor: float) -> Predicted:
        """Return this with a band that is so many times as wide; no value is negative."""
        middle, half = (self.high + self.low) / 2, factor * (self.high - self.low) / 2
        return self._replace(low=max(middle - half, 0.0), high=middle + half)


def predict(
    path: Path, robots: int, workers: int | None, watch: Callable[[float], None]
) -> list[Predicted]:
    """Return what robots that fit the first half of a recording predict of the second.

    What all of them do alike, such as a wait of 4 s, is not a prediction and is left out.

    Raises:
        UsageError: It is a table, or no robot can run the mission, as without a pipe.
        RecordingError: It cannot be read.
    """
    measured = read_measured(path)
    if measured.profile is None:
        raise UsageError("a table does not say what the robot was commanded: give a recording")
    half_s = float(measured.columns["time_s"][-1]) / 2
    numbers = robot_numbers([measured.before(half_s)])
    with TemporaryDirectory(prefix="predicted-") as folder:
        twin = Path(folder) / "twin.yaml"
        twin.write_text(twin_text(measured.profile, numbers, path.name, robots), "utf-8")
        job = partial(_simulated, path, twin)
        runs = list(in_processes(job, range(robots), workers, watch))
    failed = [each for each in runs if isinstance(each, str)]
    if len(failed) == robots:
        raise UsageError(f"no robot can run the recorded mission in the simulator: {failed[0]}")
    known = [each for each in runs if not isinstance(each, str)]
    begins = {_key(each): each.from_s for each in measured.commands}
    found = list(_bands(quantities(measured), known, begins))
    first = [each for each in found if each.from_s <= half_s]
    return _widened(first, [each for each in found if each.from_s > half_s])


def in_processes(
    job: Callable[[int], Any],
    numbers: Sequence[int],
    workers: int | None,
    watch: Callable[[float], None],
) -> Iterator[Any]:
    """Yield what a job returns for each number, in their order; processes end with the caller."""
    with get_context("spawn").Pool(workers, signal, (SIGINT, SIG_IGN)) as pool:
        for done, each in enumerate(pool.imap(job, numbers)):
            watch(done / len(numbers))
            yield each


def _simulated(path: Path, twin: Path, number: int) -> Mapping[CommandValue, float] | str:
    """Return what a robot of the sample does in the recorded mission, or why it does nothing."""
    header = replace(read_recording(path).header, zeros={})  # a simulated joint has none
    options = {key: header.options[key] for key in _KEPT_OPTIONS if key in header.options}
    backend = header.backend if header.backend in SIMULATORS else "sim"
    file = twin.with_name(f"{number}.mcap")
    try:
        with recorded_mission(header) as loaded:
            run(
                loaded,
                backend,
                seed=_SEEDS_FROM + number,
                record=file,
                check=False,
                **{**options, "twin": f"{twin}#{number}"},
            )
        return quantities(read_measured(file))
    except PirateError as error:
        return str(error)
    finally:
        file.unlink(missing_ok=True)


def quantities(measured: MeasuredFile) -> dict[CommandValue, float]:
    """Return what is known of each command of a run."""
    assert measured.profile is not None
    columns, profile = measured.columns, measured.profile
    boards = {
        str(board.id): [
            np.abs(column(columns, found[1])) * abs(found[2])
            for slot in board.slots
            if (found := load_signals(profile, slot)) is not None
        ]
        for board in profile.boards
    }
    slips = _slips(columns)
    known: dict[CommandValue, float] = {}
    for each in measured.commands:
        meanwhile = slice(*np.searchsorted(columns["time_s"], (each.from_s, each.until_s)))
        known[CommandValue(DURATION, "", *_key(each))] = each.until_s - each.from_s
        for board, loads in boards.items():
            known[CommandValue(LOAD, board, *_key(each))] = _mean(loads, meanwhile)
        known[CommandValue(SLIP, "", *_key(each))] = _mean(slips, meanwhile)
    return known


def _key(command: SentCommand) -> tuple[str, str, int]:
    return command.name, command.place, command.nth


def _slips(columns: Columns) -> list[Any]:
    names = SlipSignalNames()
    try:
        return [
            np.abs(column(columns, names.slip.format(wheel))) for wheel in wheels_in(columns, names)
        ]
    except UsageError:
        return []


def _mean(values: Sequence[Any], meanwhile: slice) -> float:
    """Return the mean of some columns over a time; NaN if too little of it is known."""
    parts = [each[meanwhile] for each in values]
    known = np.concatenate([part[np.isfinite(part)] for part in parts]) if parts else np.empty(0)
    return float(np.mean(known)) if len(known) >= _LEAST_READINGS * len(parts) > 0 else nan


def _bands(
    recorded: Mapping[CommandValue, float],
    runs: Sequence[Mapping[CommandValue, float]],
    begins: Mapping[tuple[str, str, int], float],
) -> Iterator[Predicted]:
    """Yield the band of each quantity that is known in enough runs.

    Of n values as likely as the recorded one, a band from the kth to the kth last holds it with
    (n + 1 - 2 k) / (n + 1): quantiles are taken so (Weibull).
    """
    tails = (1 - SHARE) / 2
    for quantity, value in recorded.items():
        from_s = begins[quantity[2:]]
        simulated = np.array([each.get(quantity, nan) for each in runs])
        simulated = simulated[np.isfinite(simulated)]
        if not np.isfinite(value):
            continue
        if len(simulated) < _LEAST_SHARE * len(runs):
            continue
        low, high = np.quantile(simulated, [tails, 1 - tails], method="weibull")
        if low < high:
            yield Predicted(quantity, from_s, float(low), float(high), value)


def _widened(first: Sequence[Predicted], second: Sequence[Predicted]) -> list[Predicted]:
    """Return bands of the second half, wide enough for the first one, for each kind.

    The factor is that with which the bands of the first half hold their share of it (split
    conformal prediction: Vovk, Gammerman and Shafer, Algorithmic Learning in a Random World, 2005).
    It is the error of the method, which no draw knows; bands are never made narrower.
    """
    factors = dict.fromkeys(_KINDS, 1.0)
    for kind in _KINDS:
        off = sorted(each.off for each in first if each.quantity.kind == kind)
        needed = ceil((len(off) + 1) * SHARE)
        if off and needed <= len(off):
            factors[kind] = max(1.0, off[needed - 1])
    return [each.widened(factors[each.quantity.kind]) for each in second]


def coverage(found: Sequence[Predicted]) -> dict[str, tuple[int, int]]:
    """Return of each kind how many recorded values lie in their bands, and of how many."""
    return {
        kind: (sum(each.held for each in of_kind), len(of_kind))
        for kind in _KINDS
        for of_kind in [[each for each in found if each.quantity.kind == kind]]
    }
