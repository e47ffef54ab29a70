"""What `fidelity: fast` costs and saves: each run twice, once fast and once as usual.

    python -m benchmarks.fidelity [--row NAME] [--seeds 20] [--workers 2]

The two runs of a seed have the same start, friction, diameter and noise, drawn as in
`campaigns/bend.yaml`, so what differs is the error of the coarser computation; a detector's word
that falls into another cycle is part of it. A run is right when its mission succeeds, and in bends
every wheel is beyond the joint in truth. For each row are printed: how many runs are right, how
many pairs end alike, by how much the time, the true distance and the hardest pressed joint's
torque differ at the end (the median of the pairs with its sign, and the most), and how far a robot
creeps in two seconds after its end. In round pipes also how deep a wheel is in a wall at most.

Then the speed, by processor time and in turns: of the pairs, without preparation, and of the
kernels alone, called for each cycle of 16 ms as in a mission, between bars also for many at once.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import isnan
from statistics import median
from time import process_time
from typing import NamedTuple

from benchmarks.campaign import options_of_rows, run_all
from pirate_sm.core import library
from pirate_sm.core._geometry.network import Straight, planar
from pirate_sm.core.geometry import Route, Section
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Friction
from pirate_sm.core.options import USUAL, Fidelity
from pirate_sm.lab.campaign.watched_run import Outcome
from pirate_sm.running.wiring import Order
from pirate_sm.simulation.kinematic.world import kinematic
from pirate_sm.simulation.physics import chain_of
from pirate_sm.simulation.start_pose import stand

FAST: Fidelity = "fast"
CROSSING_M = 1.0
LEAST_ALIKE = 0.99
"""Less than this share of the usual run's successes, and fast is not good enough for a row."""
KERNELS: tuple[tuple[Section, int], ...] = (("bars", 1), ("bars", 100), ("round", 1))
"""In space a call looks for walls as far as the robot may come in it, so long calls are no gain."""
CYCLE_S = 0.016
CLAMPED = {1: -0.7, 2: 0.7, 3: -0.7, 4: 0.7}
_MEASURED_S, _TURNS = 64.0, 7


@dataclass(frozen=True)
class Row:
    """A mission in a pipe.

    Attributes:
        name: What is printed, and what ``--row`` takes.
        mission: Name of the mission; ``pipe`` instead of its own.
        beyond: Whether the robot must end beyond the joint at 1 m.
    """

    name: str
    mission: str
    pipe: str | None = None
    beyond: bool = True


ROWS = (
    Row("bend, level", "mitre_bend"),
    Row("bend, tilted", "mitre_bend", "mitre_90_tilted"),
    Row("bend, from below", "take_bend", "mitre_90_from_below"),
    Row("bend, from above", "take_bend", "mitre_90_from_above"),
    Row("bend, up", "take_bend", "mitre_90_up"),
    Row("bend, down", "take_bend", "mitre_90_down"),
    Row("climb and hold", "climb", beyond=False),
    Row("drive, exp_1_round", "exp_1_round", beyond=False),
    Row("round: mitre", "take_bend", "mitre_90_round"),
    Row("round: elbow", "take_elbow", "elbow_90"),
    Row("round: tee", "take_branch", "tee_90"),
)


class Pair(NamedTuple):
    """Two runs of one seed."""

    usual: Outcome
    fast: Outcome

    def differ(self, number: Callable[[Outcome], float]) -> float:
        """Return by how much a number of the fast run is greater."""
        return number(self.fast) - number(self.usual)


def main() -> int:
    """Print each row and the speeds; return 1 when fast succeeds less often in a row."""
    names = [row.name for row in ROWS]
    wishes = options_of_rows(__doc__, names, 20, "pairs of every row").parse_args()
    good = True
    for row in ROWS:
        if row.name in (wishes.row or names):
            pairs = _pairs(row, wishes.seeds, wishes.workers)
            good &= _show(row, pairs)
    for section, cycles in KERNELS:
        usual_s, fast_s = kernel_times(section, cycles * CYCLE_S)
        print(
            f"kernel, {section}, {cycles} cycles a call: usual {usual_s * 1e6:.1f} us a cycle, "
            f"fast {fast_s * 1e6:.1f} us, {usual_s / fast_s:.2f} x faster"
        )
    return 0 if good else 1


def _pairs(row: Row, seeds: int, workers: int | None) -> list[Pair]:
    """Run the row, both ways for each seed, one after the other."""
    order = Order(
        row.mission, pipe=row.pipe,
        start_jitter_m=0.02, friction_jitter=0.20, diameter_jitter_m=0.002,
    )  # fmt: skip
    ways: tuple[Fidelity, ...] = (USUAL, FAST)
    orders = [replace(order, seed=seed, fidelity=way) for seed in range(seeds) for way in ways]
    outcomes = iter(run_all(orders, workers=workers))
    return [Pair(usual, fast) for usual, fast in zip(outcomes, outcomes, strict=True)]


def is_right(outcome: Outcome, row: Row) -> bool:
    """Return whether a run has succeeded, in truth too."""
    there = not row.beyond or min(outcome.arcs_m) > CROSSING_M
    return outcome.outcome == "succeeded" and there and not outcome.gone


def _show(row: Row, pairs: Sequence[Pair]) -> bool:
    """Print what came of a row; return whether fast succeeds as often."""
    right = [sum(is_right(each, row) for each in way) for way in zip(*pairs, strict=True)]
    both = [pair for pair in pairs if all(is_right(each, row) for each in pair)]
    alike = sum(pair.usual.outcome == pair.fast.outcome for pair in pairs)
    usual_s, fast_s = (sum(each.cpu_s for each in way) for way in zip(*pairs, strict=True))
    print(
        f"{row.name}: right usual {right[0]}, fast {right[1]} of {len(pairs)}; "
        f"{alike} end alike; missions {usual_s / fast_s:.2f} x faster"
    )
    if both:
        shares = [100 * (pair.fast.time_s / pair.usual.time_s - 1) for pair in both]
        _show_numbers("time", "%", shares)
        _show_numbers("distance", "mm", [1e3 * pair.differ(_distance) for pair in both])
        _show_numbers("torque", "mNm", [1e3 * pair.differ(_torque) for pair in both])
        print(f"        of {1e3 * median(_torque(pair.usual) for pair in both):.0f} mNm as usual")
        crept = [1e3 * max(each.slid_m for each in way) for way in zip(*both, strict=True)]
        print(f"    creep: usual at most {crept[0]:.2f} mm, fast {crept[1]:.2f} mm")
    deepest = [1e3 * max(each.deepest_m for each in way) for way in zip(*pairs, strict=True)]
    if not isnan(deepest[0]):
        print(f"    in a wall: usual at most {deepest[0]:.2f} mm, fast {deepest[1]:.2f} mm")
    for pair in pairs:
        if is_right(pair.usual, row) != is_right(pair.fast, row):
            print(
                f"    seed {pair.usual.seed}: usual: {pair.usual.message}; "
                f"fast: {pair.fast.message}"
            )
    sys.stdout.flush()
    return right[1] >= LEAST_ALIKE * right[0]


def _show_numbers(name: str, unit: str, numbers: Sequence[float]) -> None:
    most = max(numbers, key=abs)
    print(f"    {name}: median {median(numbers):+.2f} {unit}, most {most:+.2f} {unit}")


def _distance(outcome: Outcome) -> float:
    return outcome.distance_m


def _torque(outcome: Outcome) -> float:
    return max(map(abs, outcome.torques), default=0.0)


def kernel_times(section: Section, cycle_s: float) -> tuple[float, float]:
    """Return the processor time of 16 ms of the physics, usual and fast, s: the least of turns.

    Args:
        section: Of the pipe; it is straight, and the robot holds itself in it with both parts.
        cycle_s: What one call simulates.
    """
    profile = load_robot(library.find_robot("pirate_ii")).profile
    chain, route = chain_of(profile), Route(planar(0.12, (Straight(5.0),), section=section))
    pose = stand(chain, route, 1.0, CLAMPED, 0.0)
    worlds = [
        kinematic(chain, route, Friction(static=0.7, kinetic=0.5), pose, cycle_s, way)
        for way in (USUAL, FAST)
    ]
    times: tuple[list[float], list[float]] = ([], [])
    calls = round(_MEASURED_S / cycle_s)
    for world in worlds:
        world.duties[list(CLAMPED)] = list(CLAMPED.values())
    for _ in range(_TURNS):
        for world, taken in zip(worlds, times, strict=True):
            began = process_time()
            for _ in range(calls):
                world.advance()
            taken.append((process_time() - began) / calls * CYCLE_S / cycle_s)
    return min(times[0]), min(times[1])


if __name__ == "__main__":
    sys.exit(main())
