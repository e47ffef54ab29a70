"""How often a directed search meets failures, beside random sampling with as many runs.

    python -m benchmarks.falsify [--budget 200] [--within 0.3] [--workers 2]

Both change the same factors of the same missions, within a share of their ranges; random sampling
draws each uniformly. Failures are what `pirate margins MISSION --falsify` calls so: the mission
fails, or says falsely that it has succeeded. Beside them stands the size of the least change that
each has found, with every range as 1.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import perf_counter

import numpy as np

from pirate_sm.core import library
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.chunk import Chunk, RunRow, Sent, run_chunk
from pirate_sm.lab.campaign.falsify import (
    FailingChange,
    Falsified,
    Point,
    falsify,
    is_wrong,
    sides_of,
    values_at,
)
from pirate_sm.lab.campaign.margin_factors import level_of

MISSIONS = ("mitre_bend", "climb", "exp_2c_tilted")
OFTEN = 5.0
"""So much more often is wanted."""


class Runs:
    """Runs a mission with changes on all processors, each with seed 0."""

    def __init__(self, mission: str, pool: ProcessPoolExecutor) -> None:
        plan = read_campaign(library.find_mission(mission), more={"margins": {}})
        (self.cell,) = plan.cells
        self._sent = Sent(self.cell.mission, plan.missions[self.cell.mission])
        self._version, self._pool = plan.version, pool

    def __call__(self, points: Sequence[Point]) -> Sequence[RunRow]:
        """Return what came of each change."""
        cells = [level_of(self.cell, values_at(self.cell.around, each)) for each in points]
        chunks = [Chunk(c.key, c.order, c.end, c.mission, (0,), near=True) for c in cells]
        count = len(chunks)
        rows = self._pool.map(run_chunk, chunks, [self._sent] * count, [self._version] * count)
        return [row for found in rows for row in found]


def at_random(sides: Sequence[tuple[float, float]], runs: Runs, budget: int) -> Falsified:
    """Return what as many changes find that are drawn uniformly."""
    low, high = np.array(sides).T
    drawn = np.random.default_rng(0).uniform(low, high, (budget, len(sides)))
    points = [tuple(round(each, 3) for each in row) for row in drawn.tolist()]
    found = [
        FailingChange(*each) for each in zip(points, runs(points), strict=True) if is_wrong(each[1])
    ]
    least = {"failed": min(found, key=lambda each: each.size)} if found else {}
    return Falsified(least, budget, len(found))


def main() -> int:
    """Print what both have found; return 1 if the search is not as much better as is wanted."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--budget", type=int, default=200)
    parser.add_argument("--within", type=float, default=0.3, help="share of each range")
    parser.add_argument("--mission", action="append", help="three by default")
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    wishes = parser.parse_args()
    print("| mission | searched: failures | least | at random: failures | least | times as often |")
    print("|---|---|---|---|---|---|")
    reached, began = True, perf_counter()
    with ProcessPoolExecutor(wishes.workers, mp_context=get_context("spawn")) as pool:
        for mission in wishes.mission or MISSIONS:
            runs = Runs(mission, pool)
            sides = sides_of(runs.cell.around, wishes.within)
            searched = falsify(sides, runs, wishes.budget, 0)
            drawn = at_random(sides, runs, searched.runs)
            times = searched.wrong / max(drawn.wrong, 1)
            more = "≥ " if drawn.wrong == 0 else ""
            print(
                f"| `{mission}` | {_of(searched)} | {_of(drawn)} | {more}{times:.1f} × |",
                flush=True,
            )
            reached &= times >= OFTEN
    print(f"\n{perf_counter() - began:.0f} s; wanted: {OFTEN:g} × in each")
    return 0 if reached else 1


def _of(found: Falsified) -> str:
    sizes = [each.size for each in found.least.values()]
    return (
        f"{found.wrong} of {found.runs} | {min(sizes):.2f}" if sizes else f"0 of {found.runs} | –"
    )


if __name__ == "__main__":
    sys.exit(main())
