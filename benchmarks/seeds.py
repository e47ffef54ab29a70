"""How often the whole bend succeeds when start, friction, diameter and noise vary.

    python -m benchmarks.seeds [--seeds 1000] [--detector odometry] [--start-jitter 20]

Each seed shifts the start by up to 20 mm (odometry does not know by how much), friction by up to
20 %, the diameter by up to 2 mm, and draws its own sensor and detector noise. A run counts when the
mission succeeds, every wheel is beyond the bend in truth, and the nine snapshots of fig. 6-9 are a
subsequence of its states.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import yaml

from benchmarks.campaign import Outcome, run_all
from pirate_sm.wiring import Order

SNAPSHOTS = Path(__file__).with_name("fig_6_9.yaml")
CROSSING_M = 1.0


@dataclass(frozen=True)
class Case:
    """A mission in a pipe, and on which side of the crossing it must end."""

    name: str
    mission: str
    pipe: str | None
    forward: bool = True


CASES = (
    Case("horizontal", "mitre_bend", None),
    Case("28 deg tilt", "mitre_bend", "mitre_90_tilted"),
    Case("backward", "mitre_bend_backward", None, forward=False),
)


def main() -> int:
    """The share of successes of each case is printed; 1 when one is below 99 %."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=1000)
    parser.add_argument("--detector", default="sim")
    parser.add_argument("--start-jitter", type=float, default=20.0, help="mm")
    wishes = parser.parse_args()
    seeds = range(wishes.seeds)
    jitter_m = wishes.start_jitter / 1000
    snapshots = _snapshots()
    good = True
    for case in CASES:
        began = perf_counter()
        outcomes = run_all(_order(case, seed, wishes.detector, jitter_m) for seed in seeds)
        failures = {o.seed: why for o in outcomes if (why := _failure(o, case, snapshots))}
        share = 1 - len(failures) / len(outcomes)
        good &= share >= 0.99
        took = perf_counter() - began
        times = sorted(outcome.time_s for outcome in outcomes)
        print(
            f"{case.name:12} {share:7.2%} of {len(outcomes)} seeds, mission "
            f"{times[0]:.1f}/{times[len(times) // 2]:.1f}/{times[-1]:.1f} s "
            f"(least/median/most), measured in {took:.0f} s"
        )
        for why, count in Counter(failures.values()).most_common():
            which = ", ".join(str(seed) for seed, text in failures.items() if text == why)
            print(f"    {count:4} × {why} (seeds {which})")
    return 0 if good else 1


def _order(case: Case, seed: int, detector: str, start_jitter_m: float) -> Order:
    return Order(
        case.mission, pipe=case.pipe, seed=seed, detector=detector,
        start_jitter_m=start_jitter_m, friction_jitter=0.20, diameter_jitter_m=0.002,
    )  # fmt: skip


def _failure(outcome: Outcome, case: Case, snapshots: list[tuple[str, ...]]) -> str:
    """Why the run does not count; empty when it does."""
    if outcome.outcome != "succeeded":
        return outcome.message
    beyond = [arc > CROSSING_M if case.forward else arc < CROSSING_M for arc in outcome.arcs_m]
    if not all(beyond) or outcome.gone:
        return f"said to have passed, with {beyond.count(False)} wheels not beyond the crossing"
    ordered = list(outcome.arcs_m) == sorted(outcome.arcs_m, reverse=True)
    if not ordered:
        return "passed with a part folded back on itself"
    missing = _missing(outcome.states, snapshots) if case.forward else 0
    return f"{missing} snapshots of fig. 6-9 did not appear in order" if missing else ""


def _missing(states: Iterable[tuple[str, ...]], snapshots: list[tuple[str, ...]]) -> int:
    """How many snapshots are left when the states have been walked through once."""
    left = list(snapshots)
    for state in states:
        if left and state == left[0]:
            left.pop(0)
    return len(left)


def _snapshots() -> list[tuple[str, ...]]:
    # `Off` and `On` are words here, not truth values: read every scalar as text.
    rows = yaml.load(SNAPSHOTS.read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
    return [tuple(row) for row in rows.values()]


if __name__ == "__main__":
    sys.exit(main())
