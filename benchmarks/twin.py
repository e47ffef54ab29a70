"""Does `pirate fit --robot` find the numbers of a robot that it does not know?

    python -m benchmarks.twin [--seeds 6] [--times 26] [--workers 2]
    python -m benchmarks.twin --predict [--first 200] [--seeds 3] [--times 4] [--robots 19]

Each seed draws the motors and the friction of a simulated robot, which its profile assumes
otherwise. The robot records ten minutes (`benchmarks/twin.yaml`), with a ruler that measures its
speed from outside. Then the recording alone is fitted. Printed are the true number, the estimate,
its error, and its 95 % interval, with a `!` where that does not hold the true number.

With `--predict` the first half of each recording is fitted, and robots of its sample predict the
second half. Printed is how many of the recorded values the 90 % bands hold.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pirate_sm.api.result import Run
    from pirate_sm.lab.fitting.robot_numbers import RobotNumber

MISSION = Path(__file__).with_name("twin.yaml")
TIMES = 26
"""As in the mission: together they take ten minutes."""

STATIC_SHARE = 1.3
DRAWN = {
    ("wheel", "no_load_speed"): (3.0, 5.0),
    ("wheel", "stall_torque"): (0.25, 0.40),
    ("wheel", "hold_torque"): (0.05, 0.20),
    ("bend", "no_load_speed"): (0.6, 1.4),
    ("bend", "stall_torque"): (0.9, 1.3),
    ("", "kinetic friction"): (0.2, 0.6),
}
"""From where to where each number is drawn, in SI units."""

NEEDED = {
    *(("wheel", "no_load_speed"), ("bend", "no_load_speed"), ("wheel", "hold_torque")),
    *(("", "kinetic friction, front"), ("", "kinetic friction, rear")),
}
"""The five numbers that must be found within `MOST_ERROR`."""

MOST_ERROR = 0.10

BAND_OFF = 0.05
"""So far the share of values that bands hold may be off, over all."""

LEAST_OF_KIND = 0.85
"""The bands of each kind are to hold this share at least."""


@dataclass(frozen=True)
class Trial:
    """What was found of the robot of one seed: its true numbers and the fitted ones."""

    seed: int
    ended: str
    minutes: float
    rows: tuple[tuple[float, RobotNumber], ...]


def main() -> int:
    """Print what was found of each robot; return 1 unless the five numbers always were."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--times", type=int, default=TIMES, help="rounds of at least 24 s")
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--predict", action="store_true", help="check bands of the second half")
    parser.add_argument("--robots", type=int, default=32, help="of the sample, with --predict")
    wishes = parser.parse_args()
    seeds = range(wishes.first, wishes.first + wishes.seeds)
    if wishes.predict:
        return _check_bands(seeds, wishes.times, wishes.robots, wishes.workers)
    with (
        TemporaryDirectory() as folder,
        ProcessPoolExecutor(wishes.workers, mp_context=get_context("spawn")) as pool,
    ):
        trials = []
        for trial in pool.map(partial(try_out, Path(folder), wishes.times), seeds):
            _show(trial)
            trials.append(trial)
    return _sum_up(trials)


def try_out(folder: Path, times: int, seed: int) -> Trial:
    """Record the robot of this seed in a folder, and fit its numbers."""
    from pirate_sm.lab.fitting.measurements import read_measured
    from pirate_sm.lab.fitting.robot_numbers import robot_numbers

    true = drawn(seed)
    run, recording = _recorded(folder, times, seed)
    measured = read_measured(recording)
    minutes = float(measured.columns["time_s"][-1]) / 60
    rows = tuple(
        (true[number.motor, number.key.split(",")[0]], number)
        for number in robot_numbers([measured])
        if number.motor or number.is_friction
    )
    return Trial(seed, f"{run.outcome}: {run.message}", minutes, rows)


def _recorded(folder: Path, times: int, seed: int) -> tuple[Run, Path]:
    """Record the robot of this seed in a folder."""
    import pirate_sm

    twin, recording = folder / f"true_{seed}.yaml", folder / f"run_{seed}.mcap"
    twin.write_text(_twin_text(drawn(seed)), "utf-8")
    run = pirate_sm.run(
        str(MISSION), seed=seed, twin=str(twin), ruler=True, record=recording, set={"times": times}
    )
    return run, recording


def _check_bands(seeds: range, times: int, robots: int, workers: int | None) -> int:
    """Print how many values bands hold; return 1 unless it is the share that they are to hold."""
    from pirate_sm.lab.fitting.prediction import SHARE, coverage, predict

    total = Counter[str]()
    with TemporaryDirectory() as folder:
        for seed in seeds:
            _, recording = _recorded(Path(folder), times, seed)
            found = coverage(predict(recording, robots, workers, lambda share: None).predicted)
            for kind, (held, of) in found.items():
                total[kind], total[f"all {kind}"] = total[kind] + held, total[f"all {kind}"] + of
            shown = (f"{kind} {held} of {of}" for kind, (held, of) in found.items())
            print(f"seed {seed}: {', '.join(shown)}", flush=True)
    counts = {kind: (total[kind], total[f"all {kind}"]) for kind in found}
    return _judge(counts, SHARE)


def _judge(counts: Mapping[str, tuple[int, int]], wanted: float) -> int:
    """Print which shares the bands of each kind hold; return 1 unless they are as wanted."""
    least = 1.0
    for kind, (held, of) in counts.items():
        share = held / of if of else 1.0
        print(f"    {kind:<10} {held} of {of}: {share:.1%}, {LEAST_OF_KIND:.0%} is asked for")
        least = min(least, share)
    held, of = (sum(column) for column in zip(*counts.values(), strict=True))
    share = held / of if of else 0.0
    print(f"    all        {held} of {of}: {share:.1%}, {wanted:.0%} ± {BAND_OFF:.0%} is asked for")
    return 0 if abs(share - wanted) <= BAND_OFF and least >= LEAST_OF_KIND else 1


def drawn(seed: int) -> dict[tuple[str, str], float]:
    """Return the true numbers of the robot of this seed, in SI units."""
    random = Random(f"robot {seed}")
    return {which: random.uniform(*between) for which, between in DRAWN.items()}


def _twin_text(true: dict[tuple[str, str], float]) -> str:
    """Return the file that gives a simulated robot these numbers."""
    kinetic = true["", "kinetic friction"]
    lines = ["format: 1", "robot: pirate_ii"]
    lines.append(f"friction: {{static: {STATIC_SHARE * kinetic}, kinetic: {kinetic}}}")
    lines.append("motors:")
    for motor in ("wheel", "bend"):
        own = {key: value for (name, key), value in true.items() if name == motor}
        units = {key: "rad/s" if key == "no_load_speed" else "Nm" for key in own}
        numbers = ", ".join(f"{key}: {value} {units[key]}" for key, value in own.items())
        lines.append(f"  {motor}: {{{numbers}}}")
    return "\n".join([*lines, ""])


def _show(trial: Trial) -> None:
    print(f"seed {trial.seed}: {trial.minutes:.1f} min, {trial.ended}")
    for true, number in trial.rows:
        name, found = f"{number.motor} {number.key}".strip(), number.estimate
        start = f"    {name:<24} {true:6.3f} {number.unit:<5} "
        if not found.known:
            print(f"{start} unknown: {found.reason}")
            continue
        missed = "" if found.low <= true <= found.high else " !"
        error = found.value / true - 1
        between = f"[{found.low:.3f}, {found.high:.3f}]"
        print(f"{start} {found.value:6.3f} {error:+6.1%} {between}{missed}", flush=True)


def _sum_up(trials: Sequence[Trial]) -> int:
    """Print how far off the estimates are, and how many intervals hold the truth."""
    failed = False
    print("all seeds:")
    for true_and_number in zip(*(trial.rows for trial in trials), strict=True):
        number = true_and_number[0][1]
        known = [(true, each.estimate) for true, each in true_and_number if each.estimate.known]
        errors = [abs(found.value / true - 1) for true, found in known]
        held = sum(found.low <= true <= found.high for true, found in known)
        name = f"{number.motor} {number.key}".strip()
        worst = f"error {max(errors):.1%} at most, " if errors else ""
        print(
            f"    {name:<24} known {len(known)} of {len(trials)}: {worst}the interval holds the"
            f" truth in {held}"
        )
        needed = (number.motor, number.key) in NEEDED
        failed |= needed and (len(known) < len(trials) or max(errors) > MOST_ERROR)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
