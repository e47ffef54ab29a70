"""Runs the variants of a traction experiment as missions, driven by the engine's own loops."""

from __future__ import annotations

from statistics import median

import numpy as np

from pirate_sm.api import Run, run
from pirate_sm.core.errors import UsageError
from pirate_sm.lab.experiments.experiment_result import ExperimentResult, Watch
from pirate_sm.lab.experiments.needed_extras import is_missing
from pirate_sm.lab.experiments.traction_setup import OwnLoops
from pirate_sm.lab.fitting.columns import column
from pirate_sm.simulation.arrays import Floats
from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries


def repeat_with_loops(
    loops: OwnLoops, parts: tuple[str, ...], *, seeds: int = 1, watch: Watch = lambda share: None
) -> ExperimentResult:
    """Return how far the odometry of each variant was off, and where it drove.

    The values of a part are `error`, between the way of the robot and what its wheels have rolled,
    a mean of the wheels; `way`, between its outermost places; `place`, where it ended; all since
    the first drive began, and medians of the seeds.

    Args:
        loops: The missions.
        parts: Which variants.
        seeds: How many runs of each.
        watch: Receives the share that is done.

    Raises:
        LoadError: A mission cannot be loaded.
        UsageError: The backend does not know where the robot is, or a mission does not drive.
    """
    result = ExperimentResult()
    why = is_missing(loops.backend)
    if why:
        result.notes.append(f"{', '.join(parts)} on {loops.backend}: not run, {why}")
        return result
    drawn = []
    wanted = [part for part in parts if part in loops.missions]
    for number, part in enumerate(wanted):
        watch(number / len(wanted))
        runs = [run(loops.missions[part], loops.backend, seed=seed) for seed in range(seeds)]
        first = runs[0]
        result.notes.append(
            f"{part} on {loops.backend}: {first.outcome} after {first.duration_s:.1f} s,"
            f" {first.message}"
        )
        driven = [_Driven(each, loops.since) for each in runs]
        name = f"{part}.{loops.backend}"
        result.values[f"{name}.error"] = median(each.error_m for each in driven)
        result.values[f"{name}.way"] = median(float(np.ptp(each.place_m)) for each in driven)
        result.values[f"{name}.place"] = median(float(each.place_m[-1]) for each in driven)
        times, places = driven[0].times_s.tolist(), driven[0].place_m.tolist()
        drawn.append(PlotSeries(part, times, places, colour=number))
    title = f"Fig. 6-10 by the engine's own loops, on {loops.backend}: place in the pipe"
    result.figures.append(Plot(title, "time, s", "x, m", tuple(drawn)))
    return result


class _Driven:
    """A run since its first drive: where the robot was, and how far its odometry is off.

    Attributes:
        times_s: Times.
        place_m: Of the robot along the pipe, 0 at the beginning.
        error_m: What the wheels have rolled beyond the way of the robot at the end, their mean.
    """

    def __init__(self, made: Run, since: str) -> None:
        commands = zip(made.commands["name"], made.commands["time_s"], strict=True)
        begins_s = next((time for name, time in commands if name == since), None)
        poses = made.poses()
        if begins_s is None or poses is None:
            raise UsageError(
                f"{made.header.mission}: experiments need a backend that knows where the robot is,"
                f" and the command {since}"
            )
        times = np.array(poses.times_s)
        places = np.array([sum(x for x, _ in points) / len(points) for points in poses.points])
        driven = times >= begins_s
        self.times_s: Floats = times[driven]
        self.place_m: Floats = places[driven] - places[driven][0]
        self.error_m = abs(float(self.place_m[-1]) - _rolled_m(made, begins_s))


def _rolled_m(made: Run, begins_s: float) -> float:
    """Return how far the wheels have rolled since, positive forward, their mean."""
    body = made.loaded.loaded_robot.profile.body
    columns = {name: np.array(values) for name, values in made.signals.items()}
    times = columns["time_s"]
    rolled = []
    for wheel in body.wheels:
        angle = column(columns, wheel.angle)
        known = np.isfinite(angle)
        first = float(np.interp(begins_s, times[known], angle[known]))
        turned = float(angle[known][-1]) - first
        rolled.append(body.wheel_radius * wheel.direction * turned)
    return sum(rolled) / len(rolled)
