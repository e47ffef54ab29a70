"""Predicts the second half of a recording by robots that the first half leaves possible.

Each robot of the sample runs the recorded mission in the simulator with a seed of its own, so
that bands hold the noise of a run as well as what is unknown of the robot.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from math import ceil, nan
from multiprocessing import get_context
from pathlib import Path
from signal import SIG_IGN, SIGINT, signal
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from pirate_sm.api.arguments import Mission
from pirate_sm.api.result import Run
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
from pirate_sm.lab.fitting.motor_intervals import load_signals
from pirate_sm.lab.fitting.robot_numbers import robot_numbers
from pirate_sm.lab.fitting.twin_file import twin_text
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission

SHARE = 0.9
"""Share of the recorded values that bands are to hold."""

SEEDS_FROM = 1000
"""The seeds of predicting runs, so that none is that of the recording by accident."""

_LEAST_READINGS = 3
_LEAST_SHARE = 0.5
"""Of the robots that send the command, too: fewer have taken another course."""

LEAST_ROBOTS = 19
"""The 5 % position (k / (n + 1), Weibull) of fewer is below their least value."""

_LEAST_CALIBRATING = 9
"""The 90 % position of fewer is above their largest value."""

_KEPT_OPTIONS = ("defects", "ruler", "fidelity", "start_jitter_m", "diameter_jitter_m")
_KINDS = DURATION, LOAD, SLIP = ("duration", "load", "slip")
UNITS = {DURATION: "s", LOAD: "Nm", SLIP: "m/s"}

_FINEST = {LOAD: 1e-3, SLIP: 1e-4}
"""Robots that differ by less are alike [assumed]; of durations it is a cycle of the link."""

_TIME_DIGITS = 6
"""Of a duration: what a difference of two times has beyond is rounding."""


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
        alike: Whether all robots do alike, and the recorded one does not: a miss that says nothing
            of how wide bands should be.
    """

    quantity: CommandValue
    from_s: float
    low: float
    high: float
    recorded: float
    alike: bool = False

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


class Widening(NamedTuple):
    """How many times as wide the bands of a kind were made, by how many values."""

    factor: float
    values: int

    @property
    def known(self) -> bool:
        """Whether there were enough values."""
        return self.values >= _LEAST_CALIBRATING


class Prediction(NamedTuple):
    """What robots predict of the second half of a recording.

    Attributes:
        predicted: The bands.
        widened: Of each kind.
        left_out: How many quantities of the second half have no band, by the reason.
        failed: How many robots could not run the mission; ``robots``: of how many.
    """

    predicted: list[Predicted]
    widened: Mapping[str, Widening]
    left_out: Mapping[str, int]
    failed: int
    robots: int


def predict(
    path: Path, robots: int, workers: int | None, watch: Callable[[float], None]
) -> Prediction:
    """Return what robots that fit the first half of a recording predict of the second.

    What all of them and the recorded one do alike, such as a wait of 4 s, is not a prediction and
    is left out.

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
    first, second = list[Predicted](), list[Predicted]()
    left_out = Counter[str]()
    begins = {_key(each): each.from_s for each in measured.commands}
    finest = {DURATION: measured.profile.link.cycle, **_FINEST}
    for quantity, recorded in quantities(measured).items():
        from_s = begins[quantity[2:]]
        simulated = [each.get(quantity, nan) for each in known]
        found = band(quantity, from_s, recorded, simulated, finest[quantity.kind])
        if isinstance(found, Predicted):
            (first if from_s <= half_s else second).append(found)
        elif from_s > half_s:
            left_out[found] += 1
    factors = widening(first)
    wide = [each if each.alike else each.widened(factors[each.quantity.kind].factor)
            for each in second]  # fmt: skip
    return Prediction(wide, factors, left_out, len(failed), robots)


def in_processes(
    job: Callable[[int], Any],
    numbers: Sequence[int],
    workers: int | None,
    watch: Callable[[float], None],
) -> Iterator[Any]:
    """Yield what a job returns for each number, in their order.

    Raises:
        UsageError: A process was killed.
    """
    spawn = get_context("spawn")
    with ProcessPoolExecutor(workers, spawn, signal, (SIGINT, SIG_IGN)) as pool:
        try:
            for done, each in enumerate(pool.map(job, numbers)):
                watch(done / len(numbers))
                yield each
        except BrokenProcessPool:
            raise UsageError(
                "a process that simulates was killed, perhaps for want of memory: try --workers 1"
            ) from None


def _simulated(path: Path, twin: Path, number: int) -> Mapping[CommandValue, float] | str:
    """Return what a robot of the sample does in the recorded mission, or why it does nothing."""
    try:
        with simulated_again(path, twin, number) as (_, measured):
            return quantities(measured)
    except PirateError as error:
        return str(error)


@contextmanager
def simulated_again(
    path: Path, twin: Path, number: int, seeds_from: int = SEEDS_FROM
) -> Iterator[tuple[Run, MeasuredFile]]:
    """Yield what :func:`simulated` does of the mission that was recorded.

    Raises:
        PirateError: It cannot be run.
    """
    header = replace(read_recording(path).header, zeros={})  # a simulated joint has none
    with (
        recorded_mission(header) as loaded,
        simulated(loaded, header, twin, number, seeds_from) as again,
    ):
        yield again


@contextmanager
def simulated(
    mission: Mission, header: RunHeader, twin: Path, number: int, seeds_from: int = SEEDS_FROM
) -> Iterator[tuple[Run, MeasuredFile]]:
    """Yield how a mission ends for a robot of a sample, and what its recording holds.

    Args:
        mission: What is run; it is not checked.
        header: Of a recording: the robot is simulated under the same options.
        twin: The file with the sample, next to which the recording is kept for the moment.
        number: Of the robot.
        seeds_from: The seed of the first robot.

    Raises:
        PirateError: It cannot be run.
    """
    options = {key: header.options[key] for key in _KEPT_OPTIONS if key in header.options}
    backend = header.backend if header.backend in SIMULATORS else "sim"
    with TemporaryDirectory(dir=twin.parent) as folder:
        file = Path(folder) / "run.mcap"
        options |= {"twin": f"{twin}#{number}", "record": file, "seed": seeds_from + number}
        yield run(mission, backend, check=False, **options), read_measured(file)


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
        known[CommandValue(DURATION, "", *_key(each))] = round(
            each.until_s - each.from_s, _TIME_DIGITS
        )
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


def band(
    quantity: CommandValue,
    from_s: float,
    recorded: float,
    simulated: Sequence[float],
    finest: float,
) -> Predicted | str:
    """Return the band of a quantity, or why it has none.

    Of n values as likely as the recorded one, a band from the kth to the kth last holds it with
    (n + 1 - 2 k) / (n + 1): quantiles are taken so (Weibull).

    Args:
        quantity: What is predicted.
        from_s: When its command was given.
        recorded: Its value; NaN if unknown.
        simulated: That of each robot.
        finest: Robots that differ by less are alike.
    """
    if not np.isfinite(recorded):
        return "unknown in the recording"
    values = np.array([each for each in simulated if np.isfinite(each)])
    needed = max(LEAST_ROBOTS, ceil(_LEAST_SHARE * len(simulated)))
    if len(values) < needed:
        return f"known of fewer than {needed} robots"
    tails = (1 - SHARE) / 2
    low, high = map(float, np.quantile(values, [tails, 1 - tails], method="weibull"))
    alike = high - low < finest
    if alike and low - finest <= recorded <= high + finest:
        return "all robots do alike"
    return Predicted(quantity, from_s, low, high, recorded, alike)


def widening(first: Sequence[Predicted]) -> dict[str, Widening]:
    """Return how many times as wide the bands of each kind must be to hold their share.

    They are those of the first half. The robots were fitted to it, so what its bands miss is at
    least the error of the method, which no draw knows, and may be less than that of the second
    half. Bands are never made narrower.
    """
    found = dict[str, Widening]()
    for kind in _KINDS:
        off = sorted(each.off for each in first if each.quantity.kind == kind and not each.alike)
        factor = 1.0
        if len(off) >= _LEAST_CALIBRATING:
            factor = max(1.0, off[ceil((len(off) + 1) * SHARE) - 1])
        found[kind] = Widening(factor, len(off))
    return found


def coverage(found: Sequence[Predicted]) -> dict[str, tuple[int, int]]:
    """Return of each kind how many recorded values lie in their bands, and of how many."""
    return {
        kind: (sum(each.held for each in of_kind), len(of_kind))
        for kind in _KINDS
        for of_kind in [[each for each in found if each.quantity.kind == kind]]
    }
