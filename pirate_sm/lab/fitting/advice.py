"""Says which shipped mission, recorded next, would narrow the sample of a robot most.

This is Bayesian experimental design: what counts is the expected information gain of a mission
(Lindley 1956, "On a measure of the information provided by an experiment"; Chaloner and Verdinelli
1995, "Bayesian experimental design: a review"), by nested Monte Carlo (Ryan 2003, "Estimating
expected information gains for experimental designs"). Outside, robots of the sample run the
mission. Inside, each of their recordings is fitted and its draws are averaged with those at hand,
by their precision. The new sample is compared with the old one: both are taken as normal in the
logarithms of their numbers, where the gain is half the logarithm of the ratio of determinants
(Bayesian D-optimality).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import log
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from pirate_sm.api.result import read
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.loading import load_mission
from pirate_sm.core.models import Profile
from pirate_sm.lab.fitting.measurements import DRAWS, Estimate, MeasuredFile
from pirate_sm.lab.fitting.prediction import (
    SEEDS_FROM,
    in_processes,
    simulated,
    simulated_again,
)
from pirate_sm.lab.fitting.robot_numbers import RobotNumber, robot_numbers
from pirate_sm.lab.fitting.twin_file import sample_of, twin_text
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_fit, write_robot
from pirate_sm.running.recording.tables import TIME
from pirate_sm.simulation.arrays import Floats

ROBOTS = 4
"""Robots that run each mission."""

_DRAWN = 8
"""So many robots are drawn at most for each that runs."""

_OF_MISSIONS = ("succeeded", "failed")
"""Ends that depend on the robot: an operator's and a fault's do not."""

_STREAMS_FROM = 1000
"""Streams of the stretches that are drawn of simulated recordings: the recording at hand has 0."""

_AGAIN_FROM = 2 * SEEDS_FROM
"""The seeds of the recorded mission for the choice of robots, which are not those of advice."""

_KNOWN_WITHIN = 0.01
"""A number is as good as known within this share: nothing is gained by less [assumed; fits err by
up to 2.8 %, docs/measurements.md]."""

_TINY = 1e-12
"""A variance of draws that are all alike."""


class MeanGain(NamedTuple):
    """A mean over robots, and its standard error."""

    mean: float
    error: float


class MissionAdvice(NamedTuple):
    """What recording a mission is expected to tell.

    Attributes:
        mission: Its name.
        bits: Information gained.
        narrower: By which share the standard deviation of each number's logarithm falls.
        takes_s: How long the mission takes, the mean of all robots.
        succeeded: Of how many robots it succeeds.
        robots: How many could be simulated.
    """

    mission: str
    bits: MeanGain
    narrower: Mapping[str, MeanGain]
    takes_s: float
    succeeded: int
    robots: int

    def as_data(self) -> dict[str, object]:
        """Return this for JSON."""
        narrower = {name: share._asdict() for name, share in self.narrower.items()}
        return self._asdict() | {"bits": self.bits._asdict(), "narrower": narrower}


class AdvisedMissions(NamedTuple):
    """What each mission is expected to tell.

    Attributes:
        missions: In order.
        left_out: Why a mission cannot be advised, by its name.
        robots: How many robots ran the missions.
        rejected: How many did not, as they ended a recorded mission in another way.
        unchecked: Why a recording rejected none; empty if all could have.
    """

    missions: list[MissionAdvice]
    left_out: Mapping[str, str]
    robots: int
    rejected: int
    unchecked: str


class _Told(NamedTuple):
    """What the run of one robot tells, as in :class:`MissionAdvice`."""

    bits: float
    narrower: Mapping[str, float]
    takes_s: float
    succeeded: bool


def advise(
    measured: Sequence[MeasuredFile],
    missions: Sequence[Path],
    robots: int,
    workers: int | None,
    watch: Callable[[float], None],
) -> AdvisedMissions:
    """Return what each mission is expected to tell.

    A robot of the sample counts only if it ends the recorded missions as they ended: assumed
    numbers are drawn from far more than such a robot can have. That is one draw of a likelihood
    (Tavaré, Balding, Griffiths and Donnelly 1997, "Inferring coalescence times from DNA sequence
    data": rejection sampling).

    Args:
        measured: Recordings of the robot, all of them.
        missions: Files of missions, each to be loaded with the recorded robot.
        robots: How many robots of the sample run each, two at least; fewer if too few are left.
        workers: How many processes simulate; None for one each processor.
        watch: Takes the share that is done.

    Raises:
        UsageError: No robot is possible after these recordings, or none can run a mission.
    """
    profile, recording = measured[0].profile, measured[0].recording
    assert profile is not None
    assert recording is not None
    numbers = robot_numbers(measured)
    sample = sample_of(profile, numbers, _DRAWN * robots)
    if sample is None:
        raise UsageError("nothing is known or assumed of this robot that a mission could tell")
    with TemporaryDirectory(prefix="advised-") as folder:
        twin = Path(folder) / "twin.yaml"
        twin.write_text(twin_text(profile, numbers, recording.name, _DRAWN * robots), "utf-8")
        drawn = len(sample.robots)
        chosen, rejected, unchecked = _chosen(measured, twin, drawn, robots, workers)
        robots = len(chosen)
        header = read_recording(recording).header
        robot = write_robot(header, Path(folder))
        job = partial(_told, profile, header, robot, numbers, twin, missions, chosen)
        runs = list(in_processes(job, range(len(missions) * robots), workers, watch))
    found, left_out = list[MissionAdvice](), dict[str, str]()
    for number, mission in enumerate(missions):
        of_mission = runs[number * robots : (number + 1) * robots]
        told = [each for each in of_mission if isinstance(each, _Told)]
        if len(told) > 1:
            found.append(_advice(mission.stem, told))
        else:
            left_out[mission.stem] = next(each for each in of_mission if isinstance(each, str))
    if not found:
        raise UsageError(
            f"no two robots can run a mission: {next(iter(left_out.values()), 'none')}"
        )
    return AdvisedMissions(in_order(found, robots), left_out, robots, rejected, unchecked)


def _chosen(
    measured: Sequence[MeasuredFile], twin: Path, drawn: int, robots: int, workers: int | None
) -> tuple[list[int], int, str]:
    """Return the first robots that end each recorded mission as it ended.

    Returns:
        Their numbers, how many were rejected, and why a recording rejected none.

    Raises:
        UsageError: They are fewer than two.
    """
    recordings = [each.recording for each in measured if each.recording is not None]
    ends = [(path, read(path).outcome) for path in recordings]
    chosen, unchecked = list[int](), ""
    job = partial(_ends_differently, ends, twin)
    tried = in_processes(job, range(drawn), workers, lambda _: None)
    for number, found in enumerate(tried):
        if found is not True:
            chosen.append(number)
            unchecked = found or unchecked
        if len(chosen) == robots:
            return chosen, number + 1 - robots, unchecked
    if len(chosen) < 2:
        few = f"{len(chosen)} of {drawn} robots that the recordings leave possible"
        raise UsageError(f"{few} end the recorded missions as they ended: two are needed")
    return chosen, drawn - len(chosen), unchecked


def _ends_differently(ends: Sequence[tuple[Path, str]], twin: Path, number: int) -> bool | str:
    """Return whether a robot ends a mission in another way, or why that cannot be known."""
    unchecked = ""
    for path, outcome in ends:
        if outcome not in _OF_MISSIONS:
            unchecked = "the recorded mission came to no end of its own"
            continue
        try:
            with simulated_again(path, twin, number, _AGAIN_FROM) as (run, _):
                if run.outcome != outcome:
                    return True
        except PirateError as error:
            unchecked = str(error).splitlines()[0]
    return unchecked


def in_order(found: Sequence[MissionAdvice], robots: int) -> list[MissionAdvice]:
    """Return first what all robots pass, then the others, each by what it tells.

    A failure tells much, but a robot in a pipe fails by falling.
    """
    return sorted(found, key=lambda each: (each.succeeded < robots, -each.bits.mean))


def _advice(mission: str, told: Sequence[_Told]) -> MissionAdvice:
    return MissionAdvice(
        mission,
        _expected([each.bits for each in told]),
        {name: _expected([each.narrower[name] for each in told]) for name in told[0].narrower},
        float(np.mean([each.takes_s for each in told])),
        sum(each.succeeded for each in told),
        len(told),
    )


def _expected(values: Sequence[float]) -> MeanGain:
    return MeanGain(float(np.mean(values)), float(np.std(values, ddof=1)) / len(values) ** 0.5)


def _told(
    profile: Profile,
    header: RunHeader,
    robot: Path,
    numbers: Sequence[RobotNumber],
    twin: Path,
    missions: Sequence[Path],
    robots: Sequence[int],
    number: int,
) -> _Told | str:
    """Return what a mission tells of one robot, or why it cannot be run."""
    mission, robot_of = divmod(number, len(robots))
    try:
        loaded = load_mission(missions[mission], robot=str(robot), fitted=recorded_fit(header))
        with simulated(loaded, header, twin, robots[robot_of]) as (run, new):
            told = gained(profile, numbers, robot_numbers([new], _STREAMS_FROM + robots[robot_of]))
    except PirateError as error:
        return str(error).splitlines()[0]
    return _Told(*told, float(new.columns[TIME][-1]), run.outcome == "succeeded")


def gained(
    profile: Profile, known: Sequence[RobotNumber], new: Sequence[RobotNumber]
) -> tuple[float, dict[str, float]]:
    """Return how many bits two fits know more than the first, and how each number narrows."""
    told = {(each.motor, each.key): each.estimate for each in new}
    both = [
        replace(one, estimate=_averaged(one.estimate, told.get((one.motor, one.key), Estimate())))
        for one in known
    ]
    old = _logarithms(profile, known)
    now, names = _logarithms(profile, both) or old, list(old)
    covariances = [np.cov([each[name] for name in names]).reshape(len(names), -1)
                   + _KNOWN_WITHIN**2 * np.eye(len(names)) for each in (old, now)]  # fmt: skip
    (_, wide), (_, narrow) = map(np.linalg.slogdet, covariances)
    shares = 1 - np.sqrt(np.diag(covariances[1]) / np.diag(covariances[0]))
    return float(wide - narrow) / 2 / log(2), dict(zip(names, shares.tolist(), strict=True))


def _averaged(one: Estimate, other: Estimate) -> Estimate:
    """Return what two recordings say, the means of their draws, each with its precision.

    An error of the method has the same draws in both and stays: it is no smaller in their mean.
    """
    if not (one.known and other.known):
        known = one if one.known else other
        return known if known.known else replace(one, low=float(np.fmax(one.low, other.low)))
    draws = [np.log(each.likely) for each in (one, other)]
    precision = [1 / (np.nanvar(each) + _TINY) for each in draws]
    return replace(one, draws=np.exp(np.average(draws, axis=0, weights=precision)))


def _logarithms(profile: Profile, numbers: Sequence[RobotNumber]) -> dict[str, Floats]:
    sample = sample_of(profile, numbers, DRAWS)
    if sample is None:
        return {}
    return dict(zip(sample.numbers, np.log(sample.robots).T, strict=True))
