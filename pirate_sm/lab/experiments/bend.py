"""Repeats an experiment through a bend, and raises the tilt until the robot does not hold."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import degrees, dist, nan

import numpy as np

from pirate_sm.api import Run, load, run
from pirate_sm.lab.experiments.setups import BendSetup, ExperimentResult, TiltedMission, Watch


def repeat_bend(
    setup: BendSetup, parts: tuple[str, ...], *, seeds: int = 1, watch: Watch = lambda share: None
) -> ExperimentResult:
    """Return how often and how fast the bend was passed.

    Args:
        setup: The experiment.
        parts: Which of its parts.
        seeds: How many runs of each.
        watch: Receives the share that is done.

    Raises:
        LoadError: A mission cannot be loaded.
        UsageError: The simulator is not installed.
    """
    result = ExperimentResult()
    tilted = setup.tilts.of in parts
    for number, part in enumerate(parts):
        watch(0.5 * number / len(parts) if tilted else number / len(parts))
        made = [run(setup.missions[part], seed=n, defects=setup.defects) for n in range(seeds)]
        _take_in(result, part, part, made, setup)
    _compare_times(result)
    for part in (each for each in parts if each in setup.seen):
        title = f"{part} by the camera {setup.seen[part]}"
        if not result.can_run(title, "vision"):
            continue
        mission, detector = setup.missions[part], f"vision:{setup.seen[part]}"
        made = [
            run(mission, seed=n, defects=setup.defects, detector=detector) for n in range(seeds)
        ]
        _take_in(result, f"{part}.seen", title, made, setup)
    if tilted:
        for name, tilted_mission in setup.tilts.missions.items():
            angle, why = _largest_tilt(
                setup, tilted_mission, lambda share: watch(0.5 + 0.5 * share)
            )
            result.values[f"{setup.tilts.of}.{name}_tilt"] = angle
            result.notes.append(f"{setup.tilts.of}: {name} up to {degrees(angle):.0f} deg, {why}")
    return result


def _take_in(
    result: ExperimentResult, name: str, title: str, made: Sequence[Run], setup: BendSetup
) -> None:
    """Add what came of the runs of a part by this name, and a note with this title."""
    passed = [each for each in made if each.outcome == "succeeded"]
    times = [each.duration_s for each in passed]
    result.values[f"{name}.passed"] = len(passed) / len(made)
    result.values[f"{name}.time"] = float(np.median(times)) if times else nan
    seen = [_snapshots(each, list(setup.snapshots.values())) for each in passed]
    result.values[f"{name}.snapshots"] = float(min(seen, default=0))
    text = f"in {np.median(times):.1f} s (median)" if times else made[0].message
    result.notes.append(f"{title}: passed in {len(passed)} of {len(made)}, {text}")


def _compare_times(result: ExperimentResult) -> None:
    """Add every time over that of the part before it."""
    times = {name.removesuffix(".time"): v for name, v in result.values.items() if ".time" in name}
    parts = list(times)
    for before, part in pairwise(parts):
        result.values[f"{part}.over_{before}"] = times[part] / times[before]


def _snapshots(made: Run, wanted: Sequence[tuple[str, ...]]) -> int:
    """Return how many of the wanted states the run showed in their order."""
    columns = [values for name, values in made.states.items() if name != "time_s"]
    found = 0
    for states in zip(*columns, strict=True):
        if found < len(wanted) and tuple(states[: len(wanted[found])]) == wanted[found]:
            found += 1
    return found


def _largest_tilt(setup: BendSetup, tilted: TiltedMission, watch: Watch) -> tuple[float, str]:
    """Return the last tilt before the first at which the mission fails, and how it fails."""
    search, held = setup.tilts, nan
    loaded = load(tilted.mission)
    assert loaded.pipe is not None  # a simulated mission names one
    tilts = np.arange(search.begin, search.to + search.step / 2, search.step)
    for number, tilt in enumerate(tilts):
        watch(number / len(tilts))
        pipe = loaded.pipe.model_copy(update={"tilt": float(tilt)})
        made = run(replace(loaded, pipe=pipe), defects=setup.defects)
        why = _fails(made, tilted.holds, search.slides)
        if why:
            return held, f"at {degrees(tilt):.0f} deg: {why}"
        held = float(tilt)
    return held, "the last one tried"


def _fails(made: Run, holds_s: float, slides_m: float) -> str:
    """Return why the robot does not hold; empty where it does."""
    poses = made.poses()
    if made.outcome != "succeeded" or poses is None:
        return made.message
    since = min(bisect_left(poses.times_s, poses.times_s[-1] - holds_s), len(poses.times_s) - 1)
    pairs = zip(poses.points[-1], poses.points[since], strict=True)
    carried_m = max(dist(now, before) for now, before in pairs)
    return f"it slides by {carried_m * 1000:.0f} mm" if carried_m > slides_m else ""
