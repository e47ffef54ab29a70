"""Says which shipped mission, recorded next, would narrow the sample of a robot most.

This is Bayesian experimental design: missions are compared by their expected information gain
(Lindley 1956, "On a measure of the information provided by an experiment"; Chaloner and Verdinelli
1995, "Bayesian experimental design: a review"), by nested Monte Carlo (Ryan 2003, "Estimating
expected information gains for experimental designs"). In the outer loop robots of the sample run
the mission. In the inner one each of their recordings is fitted, and its draws are averaged with
those of the given recordings, weighted by precision. The new sample is compared with the old one:
both are taken as normal in the logarithms of their numbers, so the gain is half the logarithm of
the ratio of determinants (Bayesian D-optimality).
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
"""At most so many robots are drawn for each that runs."""

_COMPARED = ("succeeded", "failed")
"""Outcomes by which robots are rejected: not those of an operator or a fault."""

_STREAMS_FROM = 1000
"""Random streams of simulated recordings; the given recordings have stream 0."""

_AGAIN_FROM = 2 * SEEDS_FROM
"""The first seed of the runs that choose robots; the runs for advice have other seeds."""

_KNOWN_WITHIN = 0.01
"""A number counts as known within this share; to narrow it further gains nothing [assumed; fits err
by up to 2.8 %, docs/measurements.md]."""

_TINY = 1e-12
"""Added to variances: draws may be all equal."""


class MeanGain(NamedTuple):
    """A mean over robots, and its standard error."""

    mean: float
    error: float


class MissionAdvice(NamedTuple):
    """What a recording of a mission is expected to show.

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
    """What recordings of missions are expected to show.

    Attributes:
        missions: In order.
        left_out: Why a mission has no advice, by its name.
        robots: How many robots ran the missions.
        rejected: How many did not, since they ended a recorded mission differently.
        unchecked: Why a recording could not reject robots; empty if all could.
    """

    missions: list[MissionAdvice]
    left_out: Mapping[str, str]
    robots: int
    rejected: int
    unchecked: str


class _RunGain(NamedTuple):
    """What the run of one robot shows, as in :class:`MissionAdvice`."""

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
    """Return what recordings of missions are expected to show.

    A robot of the sample counts only if it ends the recorded missions as they ended, since assumed
    numbers are drawn from a wide range. This is rejection sampling (Tavaré, Balding, Griffiths and
    Donnelly 1997, "Inferring coalescence times from DNA sequence data").

    Args:
        measured: Recordings of the robot, all of them.
        missions: Files of missions, each to be loaded with the recorded robot.
        robots: How many robots of the sample run each, two at least; fewer if too few are left.
        workers: How many processes simulate; None for one each processor.
        watch: Called with the share that is done.

    Raises:
        UsageError: No robot is possible after these recordings, or none can run a mission.
    """
    profile, recording = measured[0].profile, measured[0].recording
    assert profile is not None
    assert recording is not None
    numbers = robot_numbers(measured)
    sample = sample_of(profile, numbers, _DRAWN * robots)
    if sample is None:
        raise UsageError("no number of this robot is known or assumed: nothing can be narrowed")
    with TemporaryDirectory(prefix="advised-") as folder:
        twin = Path(folder) / "twin.yaml"
        twin.write_text(twin_text(profile, numbers, recording.name, _DRAWN * robots), "utf-8")
        drawn = len(sample.robots)
        chosen, rejected, unchecked = _chosen(measured, twin, drawn, robots, workers)
        robots = len(chosen)
        header = read_recording(recording).header
        robot = write_robot(header, Path(folder))
        job = partial(_gain_of, profile, header, robot, numbers, twin, missions, chosen)
        runs = list(in_processes(job, range(len(missions) * robots), workers, watch))
    found, left_out = list[MissionAdvice](), dict[str, str]()
    for number, mission in enumerate(missions):
        of_mission = runs[number * robots : (number + 1) * robots]
        gains = [each for each in of_mission if isinstance(each, _RunGain)]
        if len(gains) > 1:
            found.append(_advice(mission.stem, gains))
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
    """Return whether a robot ends a recorded mission differently, or why that is unknown."""
    unchecked = ""
    for path, outcome in ends:
        if outcome not in _COMPARED:
            unchecked = "the recorded mission was stopped or ended in a fault"
            continue
        try:
            with simulated_again(path, twin, number, _AGAIN_FROM) as (run, _):
                if run.outcome != outcome:
                    return True
        except PirateError as error:
            unchecked = str(error).splitlines()[0]
    return unchecked


def in_order(found: Sequence[MissionAdvice], robots: int) -> list[MissionAdvice]:
    """Return first the missions that all robots pass, then the others, both by their gain.

    A failure shows much, but a robot in a pipe fails by falling.
    """
    return sorted(found, key=lambda each: (each.succeeded < robots, -each.bits.mean))


def _advice(mission: str, gains: Sequence[_RunGain]) -> MissionAdvice:
    return MissionAdvice(
        mission,
        _expected([each.bits for each in gains]),
        {name: _expected([each.narrower[name] for each in gains]) for name in gains[0].narrower},
        float(np.mean([each.takes_s for each in gains])),
        sum(each.succeeded for each in gains),
        len(gains),
    )


def _expected(values: Sequence[float]) -> MeanGain:
    return MeanGain(float(np.mean(values)), float(np.std(values, ddof=1)) / len(values) ** 0.5)


def _gain_of(
    profile: Profile,
    header: RunHeader,
    robot: Path,
    numbers: Sequence[RobotNumber],
    twin: Path,
    missions: Sequence[Path],
    robots: Sequence[int],
    number: int,
) -> _RunGain | str:
    """Return what a mission shows of one robot, or why it cannot be run."""
    mission, robot_of = divmod(number, len(robots))
    try:
        loaded = load_mission(missions[mission], robot=str(robot), fitted=recorded_fit(header))
        with simulated(loaded, header, twin, robots[robot_of]) as (run, new):
            gain = gained(profile, numbers, robot_numbers([new], _STREAMS_FROM + robots[robot_of]))
    except PirateError as error:
        return str(error).splitlines()[0]
    return _RunGain(*gain, float(new.columns[TIME][-1]), run.outcome == "succeeded")


def gained(
    profile: Profile, known: Sequence[RobotNumber], new: Sequence[RobotNumber]
) -> tuple[float, dict[str, float]]:
    """Return how many bits a second fit adds to the first, and how each number narrows."""
    added = {(each.motor, each.key): each.estimate for each in new}
    both = [
        replace(one, estimate=_averaged(one.estimate, added.get((one.motor, one.key), Estimate())))
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
    """Return what two recordings say: the means of their draws, weighted by precision.

    Errors of the method have the same draws in both, so they are not averaged out.
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
